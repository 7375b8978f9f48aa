// Order of the results of a search: pages before the names of the API, whose methods are many; the
// index of words is among the first. The numbers are those of Sphinx.
var Scorer = {
  score: (result) => {
    const [page, , , , score] = result;
    return page.startsWith("api/") ? score - 30 : page === "find" ? score + 12 : score;
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
