// Sets of CPUs, and how they are written.
//
// Thread safety: plain values.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace ctn::os {

// A set of CPU numbers, ascending, without duplicates.
class CpuSet {
 public:
  CpuSet() = default;
  CpuSet(std::initializer_list<int> cpus) : CpuSet(std::vector<int>(cpus)) {}
  explicit CpuSet(std::vector<int> cpus);

  const std::vector<int>& cpus() const& { return cpus_; }
  std::vector<int> cpus() && { return std::move(cpus_); }  // a loop over a temporary's CPUs would dangle otherwise
  bool empty() const { return cpus_.empty(); }
  std::size_t size() const { return cpus_.size(); }
  bool contains(int cpu) const;
  friend bool operator==(const CpuSet&, const CpuSet&) = default;

 private:
  std::vector<int> cpus_;
};

// The CPUs that are in both.
CpuSet common(const CpuSet& some, const CpuSet& others);

// "0-3,5" both ways, as Linux writes lists of CPUs. Errors: kCaller.
Result<CpuSet> parse_cpu_list(const std::string& text);
std::string to_string(const CpuSet& cpus);

}  // namespace ctn::os
