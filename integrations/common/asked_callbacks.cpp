#include "common/asked_callbacks.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <set>
#include <utility>

namespace catan_ros {
namespace {

constexpr std::size_t kMostNames = 12;  // of a kind; a program may have hundreds

std::string all_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t index = 0; index < std::min(names.size(), kMostNames); ++index) {
    text += (index == 0 ? "" : ", ") + names[index];
  }
  return names.size() <= kMostNames ? text : text + " and " + std::to_string(names.size() - kMostNames) + " more";
}

}  // namespace

void AskedCallbacks::note(Binding::Kind kind, const std::string& name, const std::string& nodelet) {
  add({kind, name, nodelet});
}

void AskedCallbacks::note_timer(std::chrono::nanoseconds period, const std::string& nodelet) {
  add({Binding::Kind::kTimer, period_text(period), nodelet});
}

void AskedCallbacks::finish() {
  finished_ = true;
  all_ = {};
}

void AskedCallbacks::add(Asked asked) {
  if (finished_) return;
  if (std::find(all_.begin(), all_.end(), asked) == all_.end()) all_.push_back(std::move(asked));
}

// Empty: of any nodelet.
std::vector<std::string> AskedCallbacks::names(Binding::Kind kind, const std::string& nodelet) const {
  std::set<std::string> found;
  for (const Asked& one : all_) {
    if (one.kind == kind && (nodelet.empty() || one.nodelet == nodelet)) found.insert(one.name);
  }
  return {found.begin(), found.end()};
}

std::vector<std::string> AskedCallbacks::nodelets() const {
  std::set<std::string> found;
  for (const Asked& one : all_) {
    if (!one.nodelet.empty()) found.insert(one.nodelet);
  }
  return {found.begin(), found.end()};
}

std::string AskedCallbacks::text_for(const Binding& binding) const {
  const std::vector<std::string> known = nodelets();
  if (!binding.nodelet.empty() && std::find(known.begin(), known.end(), binding.nodelet) == known.end()) {
    return known.empty() ? "no callback of a nodelet is known there" : "of nodelets there are " + all_of(known);
  }
  std::vector<std::string> parts;
  const std::array<std::pair<Binding::Kind, const char*>, 3> kinds{{{Binding::Kind::kTopic, "subscriptions of "},
                                                                    {Binding::Kind::kTimer, "timers of "},
                                                                    {Binding::Kind::kService, "services "}}};
  for (const auto& [kind, what] : kinds) {
    const std::vector<std::string> found = names(kind, binding.nodelet);
    if (!found.empty()) parts.push_back(what + all_of(found));
  }
  if (parts.empty()) return "it has no callbacks of topics, timers or services";
  std::string text = "it has ";
  for (std::size_t index = 0; index < parts.size(); ++index) text += (index == 0 ? "" : "; ") + parts[index];
  return text;
}

std::string period_text(std::chrono::nanoseconds period) {
  std::array<char, 64> text{};
  const double milliseconds = std::chrono::duration<double, std::milli>(period).count();
  std::snprintf(text.data(), text.size(), "%.6g ms (%.4g Hz)", milliseconds, 1e3 / milliseconds);
  return text.data();
}

}  // namespace catan_ros
