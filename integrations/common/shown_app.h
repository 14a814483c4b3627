// The app that Catan schedules, as a framework's own tools are told of it: diagnostics, figures, and settings that may
// be changed. app_status.h makes these of Catan's documents; a framework's adapter shows them.
//
// Adapters are libraries of their own, so that the command needs no framework, and may be compiled for C++17, which
// some frameworks' headers need: so must this header.
//
// Units: milliseconds and hertz where names say so. Thread safety: plain values.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace catan_ros {

struct Diagnostic {
  // As ROS numbers them (diagnostic_msgs/DiagnosticStatus).
  enum class Level { kOk = 0, kWarning = 1, kError = 2 };

  std::string name;  // "app", "plan", "chain scan -> LM", "subchain local", "node LM"
  Level level = Level::kOk;
  std::string message;  // one line
  std::vector<std::pair<std::string, std::string>> values;
};

// A response time of the objective, of the last seconds.
struct ResponseTime {
  std::string name;                 // "scan_LM_LP": may be part of a topic's name; no two are the same
  std::optional<double> mean_ms{};  // none: there was no response
  std::optional<double> p95_ms{};
};

// What may be changed while the app runs.
struct Setting {
  enum class Kind { kWeight, kMax, kMinRate };

  std::string name;  // "weight_scan_LM", "max_ms_scan_LM", "min_rate_hz_LM"; no two are the same
  std::string description;
  Kind kind = Kind::kWeight;
  std::string of;      // as ctn::Changes names it
  double value = 0.0;  // of bounds: 0, if there is none
};

struct AppStatus {
  std::vector<Diagnostic> diagnostics;
  std::vector<ResponseTime> response_times;
  std::vector<Setting> settings;  // empty: they are not known at present
  std::string live;               // documents, as JSON; empty: not there at present
  std::string plan;
};

class ShownApp {
 public:
  virtual ~ShownApp() = default;
  // Takes up to two seconds where the app does not answer.
  virtual AppStatus read() = 0;
  // New values of settings, by their names, all or none. Empty, or why that is refused.
  virtual std::string change(const std::vector<std::pair<std::string, double>>& values) = 0;
};

}  // namespace catan_ros
