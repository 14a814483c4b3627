#include "common/observation.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <utility>

#include "common/fields.h"

namespace catan_ros {
namespace {

constexpr std::string_view kFileEnding = ".observed";
constexpr std::string_view kSingle = "single";
constexpr std::string_view kMulti = "multi";

std::string name_of(const ObservedCallback& callback) {
  return callback.kind == Binding::Kind::kTimer ? std::to_string(callback.period.count()) : callback.name;
}

std::optional<ObservedCallback> parse_callback(const std::vector<std::string_view>& fields) {
  if (fields.size() != 5 && fields.size() != 7) return std::nullopt;
  const std::optional<Binding::Kind> kind = parse_kind(fields[2]);
  if (!kind) return std::nullopt;
  ObservedCallback callback;
  callback.kind = *kind;
  callback.type = fields[4] == kEmptyField ? std::string_view() : fields[4];
  if (fields.size() == 7) {
    if (fields[6] != kSingle && fields[6] != kMulti) return std::nullopt;
    callback.nodelet = fields[5];
    callback.one_at_a_time = fields[6] == kSingle;
  }
  if (*kind == Binding::Kind::kTimer) {
    const std::optional<std::int64_t> period = parse_number(fields[3]);
    if (!period) return std::nullopt;
    callback.period = std::chrono::nanoseconds{*period};
  } else {
    callback.name = fields[3];
  }
  return callback;
}

std::optional<ObservedRun> parse_run(const std::vector<std::string_view>& fields) {
  if (fields.size() != 7) return std::nullopt;
  const auto thread = parse_number(fields[2]);
  const auto begin = parse_number(fields[3]);
  const auto cpu_time = parse_number(fields[4]);
  if (!thread || !begin || !cpu_time) return std::nullopt;
  ObservedRun run;
  run.thread = *thread;
  run.begin = std::chrono::nanoseconds{*begin};
  run.cpu_time = std::chrono::nanoseconds{*cpu_time};
  if (fields[5] != kEmptyField) run.from = fields[5];
  run.published = read_list(fields[6]);
  return run;
}

}  // namespace

bool of_one_program(const ObservedCallback& a, const ObservedCallback& b) {
  return a.ros_node == b.ros_node && a.nodelet == b.nodelet;
}

const std::string& program_of(const ObservedCallback& callback) {
  return callback.nodelet.empty() ? callback.ros_node : callback.nodelet;
}

std::unique_ptr<ObservationLog> ObservationLog::open(const std::string& folder, const std::string& ros_node) {
  const std::string path = folder + "/" + std::to_string(::getpid()) + std::string(kFileEnding);
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return nullptr;
  std::unique_ptr<ObservationLog> log(new ObservationLog(file));
  log->write("node\t" + ros_node + "\n");
  return log;
}

ObservationLog::~ObservationLog() { ::close(file_); }

std::size_t ObservationLog::add(const ObservedCallback& callback) {
  const std::size_t number = count_.fetch_add(1);
  const std::string_view calls = callback.one_at_a_time ? kSingle : kMulti;
  const std::string nodelet_fields =
      callback.nodelet.empty() ? std::string() : "\t" + callback.nodelet + "\t" + std::string(calls);
  write("callback\t" + std::to_string(number) + "\t" + std::string(kind_text(callback.kind)) + "\t" +
        name_of(callback) + "\t" + std::string(or_nothing(callback.type)) + nodelet_fields + "\n");
  return number;
}

void ObservationLog::add_run(std::size_t callback, const ObservedRun& run) {
  const std::string published = list_text(run.published);
  write("run\t" + std::to_string(callback) + "\t" + std::to_string(run.thread) + "\t" +
        std::to_string(run.begin.count()) + "\t" + std::to_string(run.cpu_time.count()) + "\t" +
        std::string(or_nothing(run.from)) + "\t" + std::string(or_nothing(published)) + "\n");
}

// What cannot be written is not known: the program goes on.
void ObservationLog::write(const std::string& line) const {
  if (::write(file_, line.data(), line.size()) < 0) return;
}

std::vector<ObservedCallback> parse_observations(std::string_view text) {
  std::vector<ObservedCallback> callbacks;
  std::vector<std::size_t> numbers;
  std::string ros_node;
  // Without its end a line may be cut off.
  while (text.find('\n') != std::string_view::npos) {
    const std::size_t end = text.find('\n');
    const std::vector<std::string_view> fields = split(text.substr(0, end), '\t');
    text.remove_prefix(end + 1);
    if (fields[0] == "node" && fields.size() == 2) {
      ros_node = fields[1];
      continue;
    }
    const auto number = fields.size() > 1 ? parse_number(fields[1]) : std::nullopt;
    if (!number) continue;
    const auto known = std::find(numbers.begin(), numbers.end(), static_cast<std::size_t>(*number));
    if (fields[0] == "callback" && known == numbers.end()) {
      std::optional<ObservedCallback> callback = parse_callback(fields);
      if (!callback) continue;
      callback->ros_node = ros_node;
      numbers.push_back(static_cast<std::size_t>(*number));
      callbacks.push_back(std::move(*callback));
    } else if (fields[0] == "run" && known != numbers.end()) {
      std::optional<ObservedRun> run = parse_run(fields);
      if (run) callbacks[static_cast<std::size_t>(known - numbers.begin())].runs.push_back(std::move(*run));
    }
  }
  return callbacks;
}

std::vector<ObservedCallback> read_observations(const std::string& folder) {
  std::vector<ObservedCallback> all;
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(folder, failed)) {
    if (entry.path().extension() != kFileEnding) continue;
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    std::vector<ObservedCallback> callbacks = parse_observations(text.str());
    all.insert(all.end(), std::make_move_iterator(callbacks.begin()), std::make_move_iterator(callbacks.end()));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.ros_node < b.ros_node; });
  return all;
}

}  // namespace catan_ros
