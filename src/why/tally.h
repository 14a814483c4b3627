// Adds up the responses of one chain, which are taken apart one after the other: how many were late by which cause,
// what is usual of each part, and the longest ones.
//
// A cause can only be found once it is known what is usual, so of each late response what its cause depends on is kept,
// packed.
//
// Units: in the types. Thread safety: none; one owner. Memory: 4 bytes for each kind and node of a response's parts,
// about 7 for each of those of a late response, and the longest ones.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "graph/app.h"
#include "why/analysis.h"
#include "why/causes.h"
#include "why/history.h"
#include "why/parts.h"
#include "why/survey.h"

namespace ctn::why {

class Tally {
 public:
  // `worst`: how many of the longest responses are kept.
  Tally(std::size_t term, std::optional<Nanos> bound, const Lengths& lengths, std::size_t worst);

  // The next response, in the order of their ends. `history` has what happened in it.
  void add(Response response, const History& history);
  // To be called once, after all were added.
  Analysis finish(const graph::Graph& graph);

 private:
  struct Kept {
    Response response;
    Causes::Evidence evidence;
  };

  void drop_shorter();

  Analysis analysis_;
  bool usually_late_;
  std::size_t worst_;
  Causes causes_;
  std::string late_;  // packed, in the order in which they were added
  std::vector<Kept> longest_;
};

}  // namespace ctn::why
