// The colours of what has none of its own on a page: lanes of cores, modes of a node. The colour-blind can tell the
// first ones apart, as far as that is possible with so many, on light and dark ground. The scripts of the live page and
// of the page of a run begin with this file, and src/page/page.cpp gets the list from it.
const kPalette = ['#3d8fd1', '#e8a317', '#2fa67c', '#d9643a', '#b07cc6', '#6cc0e8', '#a8a13a', '#e07fa8', '#7d8fa3',
  '#b5835a'];

function colourOf(index) {
  return index < kPalette.length ? kPalette[index] : `hsl(${(index * 137) % 360} 45% 55%)`;
}

