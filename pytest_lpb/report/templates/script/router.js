// The address decides what is seen: #/overview, #/scenario/NAME, #/trial/NODEID?with=...&t=...
const SEEN_IN = { scenario: "scenarios" }; // routes that another view's element shows
const pageTitle = document.title;
const places = new Map(); // address -> how far down it was read
let current = null, linked = false;

async function route() {
  const { view, rest, params } = address.read();
  // A view that this report has: one of an empty run has no trials.
  const name = document.querySelector(`.view[data-view="${CSS.escape(SEEN_IN[view] || view)}"]`) ? view : "overview";
  const seen = SEEN_IN[name] || name;
  if (current !== null) places.set(current, scrollY);
  if (trialPlayer && name !== "trial") { trialPlayer.close(); trialPlayer = null; }
  const here = location.hash;
  all(".view").forEach((node) => node.classList.toggle("shown", node.dataset.view === seen));
  all("nav a").forEach((link) => {
    if (link.getAttribute("href") === "#/" + seen || (seen === "trial" && link.getAttribute("href") === "#/trials")) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  });
  if (!views[name]) all(".view.shown table.sortable").forEach((table) => restoreOrder(table, params));
  const special = await views[name]?.(rest, params);
  if (location.hash.split("?")[0] !== here.split("?")[0]) return; // the reader went on meanwhile
  const heading = document.querySelector(".view.shown h2")?.textContent.trim();
  document.title = `${typeof special === "string" ? special : heading || ""} – ${pageTitle}`;
  scrollTo(0, linked ? 0 : places.get(location.hash) || 0);
  if (linked) document.getElementById("content").focus({ preventScroll: true });
  linked = false;
  current = location.hash;
  document.documentElement.dataset.route = location.hash; // the view is complete
}
