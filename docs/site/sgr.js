// Colours grammars: the language `sgr` for highlight.js, which mdBook loads before this file.
(() => {
  const keyword =
    "grammar use param part actuator symmetry begin rule require pattern actuation actuate model simulate term maximize minimize " +
    "search let enum record prefer task example variant table target prototype cell lattice fallback observe novelty scenarios allow sense policy " +
    "place match choose when unless attach set remove replace revert fill paint clear weight shared vary state next noise delay drive mutate flip bound " +
    "step refuse expect narrow drop add feature known case port with free where in to turned by as from of on for over because " +
    "if then else and or not is adds at facing about per otherwise forall exists";
  hljs.registerLanguage("sgr", () => ({
    keywords: { keyword, literal: "true false nothing none" },
    contains: [
      hljs.COMMENT("#", "$"),
      hljs.QUOTE_STRING_MODE,
      { className: "number", begin: /\b\d+(\.\d+)?([eE][+-]?\d+)?( ?(%|[a-zA-Zµμ]+(\^-?\d)?([*/][a-zA-Z]+(\^-?\d)?)*)(?= *[,;)\]}.#\n]| in | by | \.\.))?/ },
    ],
  }));
  for (const block of document.querySelectorAll("code.language-sgr")) {
    block.removeAttribute("data-highlighted");
    block.classList.remove("hljs");
    (hljs.highlightElement || hljs.highlightBlock)(block);
  }
})();
