// What callbacks a program has asked its framework for: what a binding that names none of them is told with.
//
// Thread safety: plain values.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/binding.h"

namespace catan_ros {

class AskedCallbacks {
 public:
  // Of the nodelet, or of none that is known: a subscription, a service, a timer. One that is known already is the
  // same.
  void note(Binding::Kind kind, const std::string& name, const std::string& nodelet);
  void note_timer(std::chrono::nanoseconds period, const std::string& nodelet);

  // What there is in place of what the binding names, of its nodelet where it names one: "it has subscriptions of
  // /data, /ticks, and timers of 20 ms (50 Hz)", or that it has none.
  std::string text_for(const Binding& binding) const;

  // All has been told: lets go of what it knows, and notes nothing from now on.
  void finish();

 private:
  struct Asked {
    Binding::Kind kind = Binding::Kind::kTopic;
    std::string name;  // of a timer its period, as text
    std::string nodelet;

    friend bool operator==(const Asked&, const Asked&) = default;
  };
  void add(Asked asked);
  std::vector<std::string> names(Binding::Kind kind, const std::string& nodelet) const;
  std::vector<std::string> nodelets() const;

  std::vector<Asked> all_;
  bool finished_ = false;
};

// "33.333 ms (30 Hz)".
std::string period_text(std::chrono::nanoseconds period);

}  // namespace catan_ros
