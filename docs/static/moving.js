// "move it" in a page: a click loads the page of the viewer, another removes it
for (const link of document.querySelectorAll(".moving a")) {
  link.addEventListener("click", (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return; // a window of its own
    event.preventDefault();
    const shown = link.parentElement.querySelector("iframe");
    if (shown) {
      shown.remove();
      link.textContent = "move it";
      return;
    }
    const frame = document.createElement("iframe");
    frame.title = "the machine moves";
    frame.allow = "fullscreen";
    frame.src = `${link.href}#play`;
    link.parentElement.append(frame);
    link.textContent = "close";
  });
}
