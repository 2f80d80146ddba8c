// What the theme leaves out for people who use a keyboard or a screen reader.
"use strict";

addEventListener("DOMContentLoaded", () => {
  document.querySelectorAll(".caption[role=heading]").forEach((caption) => caption.setAttribute("aria-level", "2"));
  document.querySelector(".sidebar-drawer")?.setAttribute("aria-label", "Pages");
  document.querySelector(".toc-drawer")?.setAttribute("aria-label", "Contents of this page");
  if (!document.querySelector("h1")) {
    // the page of the search has none
    const heading = document.createElement("h1");
    heading.textContent = "Search";
    document.querySelector("article")?.prepend(heading);
  }
  document.querySelectorAll("thead th").forEach((cell) => {
    // a corner heads nothing
    if (!cell.textContent.trim()) cell.replaceWith(document.createElement("td"));
  });
  // what scrolls is reached by keyboard
  const watcher = new ResizeObserver((seen) =>
    seen.forEach(({ target: box }) => {
      if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
      else box.removeAttribute("tabindex");
    }),
  );
  document.querySelectorAll("article pre, article .table-wrapper").forEach((box) => watcher.observe(box));
});
