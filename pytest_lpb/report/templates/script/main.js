document.addEventListener("click", (event) => {
  const link = event.target.closest("a[href^='#']");
  if (!link) return;
  if (link.classList.contains("skip")) {
    event.preventDefault();
    document.getElementById("content").focus();
  } else linked = true;
});
history.scrollRestoration = "manual";
addEventListener("hashchange", () => { if (location.hash === "" || location.hash.startsWith("#/")) route(); });
all("table.cards").filter((table) => table.tHead).forEach(label);
document.documentElement.classList.add("js");
route();
