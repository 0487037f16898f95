// SPDX-FileCopyrightText: 2026 The heading_intercompare authors
// SPDX-License-Identifier: Apache-2.0
//
// What a page scores in the search of the site: as by default, but every page for people comes
// before every page of a module.
var Scorer = {
  score: ([docname, title, anchor, description, score]) =>
    docname.startsWith('reference/api/') ? score - 1000 : score,
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
