// What a parser of this module has found wrong so far.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace ctn::config {

class Problems {
 public:
  void add(const Place& place, std::string key, std::string what, std::string hint) {
    list_.push_back({place, std::move(key), std::move(what), std::move(hint)});
  }
  // An error of a function that knows neither the place nor the key, such as those of quantity.h.
  void add(const Place& place, const std::string& key, const Error& error);

  // What another stage found; of the same key, what was found first is enough.
  void merge(const Error& error);

  bool empty() const { return list_.empty(); }

  // All of them in order of place, the first hundred in full. Precondition: not empty.
  Error to_error() &&;

 private:
  std::vector<Problem> list_;
};

}  // namespace ctn::config
