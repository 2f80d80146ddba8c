"""The look of every page: readable on a phone, by night and on paper; no fonts or scripts from elsewhere."""

from __future__ import annotations

CSS = """
:root{--ink:#1a1a1a;--muted:#555;--line:#ccc;--soft:#f4f4f2;--link:#00518a;--page:#fff;color-scheme:light dark}
@media(prefers-color-scheme:dark){:root{--ink:#e8e8e8;--muted:#a8a8a8;--line:#4a4a4a;--soft:#262626;--link:#8ec7f0;--page:#161616}}
*{box-sizing:border-box}
body{margin:0;font:16px/1.5 system-ui,"Segoe UI","DejaVu Sans",Arial,sans-serif;color:var(--ink);background:var(--page)}
header,main,footer{max-width:68rem;margin:0 auto;padding:0 1rem}
h1{font-size:1.6rem;line-height:1.2;margin:1.2rem 0 .3rem;overflow-wrap:anywhere}
h2{font-size:1.25rem;margin:2rem 0 .5rem;padding-top:.5rem;border-top:1px solid var(--line)}
p,ul{max-width:46rem;margin:.5rem 0}
a{color:var(--link)}
.sub,figcaption,caption,.small{color:var(--muted);font-size:.9rem}
.say{border-left:4px solid var(--ink);background:var(--soft);padding:.5rem .8rem;max-width:46rem;margin:.8rem 0}
.good{border-color:#009E73}.usable{border-color:#E69F00}.bad{border-color:#D55E00}
.say strong:first-child{font-size:1.1rem}
.tiles{display:flex;flex-wrap:wrap;gap:.6rem;padding:0;margin:.8rem 0;list-style:none;max-width:none}
.tiles li{border:1px solid var(--line);padding:.4rem .8rem;min-width:8rem;flex:0 1 auto}
.tiles b{display:block;font-size:1.2rem}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,27rem),1fr));gap:1.2rem;align-items:start}
.small-ones{grid-template-columns:repeat(auto-fill,minmax(min(100%,13rem),1fr))}
figure{margin:0}
figure h3{font-size:1.05rem;margin:0 0 .3rem}
figure img,figure svg{display:block;width:100%;height:auto;background:#fff;border:1px solid var(--line)}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:.86rem;margin:.5rem 0;font-variant-numeric:tabular-nums}
caption{text-align:left;padding:.2rem 0}
th,td{padding:.15rem .8rem .15rem 0;text-align:left;vertical-align:top}
th{border-bottom:1px solid var(--ink);vertical-align:bottom}
td{border-bottom:1px solid var(--line)}
.n{text-align:right}
details{margin:.8rem 0}
summary{cursor:pointer;color:var(--link)}
dl{display:grid;grid-template-columns:minmax(5rem,auto) minmax(0,1fr);gap:.2rem 1rem;max-width:52rem;margin:.5rem 0}
dt{font-weight:600}dd{margin:0;overflow-wrap:anywhere}
footer{margin:2rem auto}
@media print{body{font-size:10pt}.wide{overflow:visible}figure,tr{break-inside:avoid}
details:not([open])>*{display:none}}
"""
