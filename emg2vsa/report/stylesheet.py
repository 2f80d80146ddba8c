"""The look of every page: one column, readable on a phone and on paper, no fonts or scripts from elsewhere."""

from __future__ import annotations

CSS = """
:root{--ink:#1a1a1a;--muted:#555;--line:#ccc;--soft:#f4f4f2;--link:#00518a}
*{box-sizing:border-box}
body{margin:0;font:16px/1.5 system-ui,"Segoe UI","DejaVu Sans",Arial,sans-serif;color:var(--ink);background:#fff}
header,nav,main,footer{max-width:68rem;margin:0 auto;padding:0 1rem}
h1{font-size:1.6rem;line-height:1.2;margin:1.2rem 0 .3rem}
h2{font-size:1.25rem;margin:2.2rem 0 .5rem;padding-top:.5rem;border-top:1px solid var(--line)}
h3{font-size:1.05rem;margin:1.4rem 0 .3rem}
p,ul{max-width:46rem;margin:.5rem 0}
a{color:var(--link)}
nav ul{display:flex;flex-wrap:wrap;gap:.2rem 1rem;list-style:none;padding:0;max-width:none}
.sub,figcaption,caption,.small{color:var(--muted);font-size:.9rem}
.say{border-left:4px solid var(--ink);background:var(--soft);padding:.5rem .8rem;max-width:46rem;margin:.8rem 0}
.good{border-color:#009E73}.usable{border-color:#E69F00}.repeat,.unreadable{border-color:#D55E00}
.say strong:first-child{font-size:1.1rem}
.tiles{display:flex;flex-wrap:wrap;gap:.6rem;padding:0;margin:.8rem 0;list-style:none;max-width:none}
.tiles li{border:1px solid var(--line);padding:.4rem .8rem;min-width:8rem}
.tiles b{display:block;font-size:1.2rem}
figure{margin:1rem 0}
figure svg{display:block;width:100%;height:auto}
.wide{overflow-x:auto}
@media(max-width:40rem){.wide table{min-width:34rem}}
table{border-collapse:collapse;font-size:.86rem;margin:.5rem 0;font-variant-numeric:tabular-nums}
caption{text-align:left;padding:.2rem 0}
th,td{padding:.15rem .6rem .15rem 0;text-align:left;vertical-align:top}
th{border-bottom:1px solid var(--ink);vertical-align:bottom}
td,tbody th{border-bottom:1px solid #e6e6e6;font-weight:inherit}
.n{text-align:right}
details{margin:.5rem 0}
summary{cursor:pointer;color:var(--link)}
dl{display:grid;grid-template-columns:minmax(5rem,auto) minmax(0,1fr);gap:.2rem 1rem;max-width:52rem;margin:.5rem 0}
dt{font-weight:600}dd{margin:0}
code{font-size:.85rem;overflow-wrap:anywhere}
.skip{position:absolute;left:-99rem}.skip:focus{left:1rem;top:.5rem;background:#fff}
@media print{nav,.skip{display:none}body{font-size:10pt}.wide{overflow:visible}figure,tr{break-inside:avoid}
h2{break-after:avoid}a{color:inherit;text-decoration:none}details:not([open])>*{display:none}}
"""
