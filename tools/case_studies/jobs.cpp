#include "jobs.h"

#include <fmt/format.h>
#include <signal.h>  // kill: POSIX

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>

#include "experiments/shell.h"
#include "map_file.h"
#include "program/inputs.h"
#include "program/text_file.h"
#include "world/world_file.h"

namespace ctn::case_studies {
namespace {

using experiments::quoted;

// How many seconds of runs are done in one go: more, and processes end at more different times; fewer, and more time
// goes into starting them.
constexpr double kTurn = 600.0;
constexpr auto kLook = std::chrono::milliseconds(200);

std::string command_of(const std::string& program, const std::vector<std::string>& arguments) {
  std::string command = quoted(program);
  for (const std::string& argument : arguments) command += " " + quoted(argument);
  return command;
}

std::string unfinished(const std::string& file) { return file + ".unfinished"; }

const App& app_of(const Study& study, const Plan& plan) { return plan.apps.at(study.program); }

std::filesystem::path folder_of(const Study& study, const Plan& plan) { return app_of(study, plan).folder / study.id; }

// All but the record.
std::vector<std::string> measuring_arguments(const Measurement& measurement, const Plan& plan) {
  std::vector<std::string> arguments = measurement.arguments;
  // Of a seed that no batch has.
  arguments.insert(arguments.end(), {"--seed", std::to_string(plan.seed - 1)});
  return arguments;
}

// A map's file, and that of the image that it may name.
std::vector<std::string> files_of_map(const std::string& map, const std::string& program) {
  const std::string file = file_of_map(map, program);
  return {file, navigation::world::image_of(file)};
}

// Its name tells apart what is measured: by the arguments, and by what the files hold that they name.
std::filesystem::path record_of(const Study& study, const Measurement& measurement, const Plan& plan) {
  std::string all;
  std::string before;
  for (const std::string& argument : measuring_arguments(measurement, plan)) {
    all += argument + '\0';
    const std::vector<std::string> files =
        before == "--map" ? files_of_map(argument, app_of(study, plan).program) : std::vector<std::string>{argument};
    for (const std::string& file : files) {
      std::error_code error;
      if (!std::filesystem::is_regular_file(file, error)) continue;
      all += program::text_of_file(file).value_or("") + '\0';
    }
    before = argument;
  }
  return folder_of(study, plan) / (measurement.name + "-" + program::short_fingerprint_of(all) + ".catan");
}

// Precondition: the study has a measurement of that name.
std::filesystem::path record_of(const Study& study, const std::string& measurement, const Plan& plan) {
  return record_of(study, *std::ranges::find(study.measurements, measurement, &Measurement::name), plan);
}

Job measuring(const Study& study, const Measurement& measurement, const Plan& plan) {
  const std::filesystem::path record = record_of(study, measurement, plan);
  std::vector<std::string> arguments = measuring_arguments(measurement, plan);
  arguments.insert(arguments.end(), {"--record", unfinished(record.string())});
  return {.name = study.id + "/" + measurement.name,
          .command = "exec " + command_of(app_of(study, plan).program, arguments),
          .seconds = measurement.seconds,
          .writes = record.string()};
}

Stage stage_of(const Batch& batch) {
  if (batch.live) return Stage::kLive;
  return batch.calibration.empty() ? Stage::kVirtual : Stage::kCalibrated;
}

struct Turn {
  const Study* study;
  const Batch* batch;
  int number;  // of the batch's turns
  int first;   // of its runs
  int runs;
};

// What the program is to do, without which runs of it, and as in which they cost.
std::vector<std::string> arguments_of_batch(const Study& study, const Batch& batch, const Plan& plan) {
  std::vector<std::string> arguments = batch.arguments;
  if (!batch.costs.empty()) {
    arguments.insert(arguments.end(), {"--costs", record_of(study, batch.costs, plan).string()});
  }
  return arguments;
}

Job running(const Turn& turn, const Plan& plan) {
  const Study& study = *turn.study;
  const Batch& batch = *turn.batch;
  const std::filesystem::path folder = folder_of(study, plan);
  std::vector<std::string> arguments = arguments_of_batch(study, batch, plan);
  if (!batch.calibration.empty()) {
    arguments.insert(arguments.end(), {"--calibration", (folder / batch.calibration).string()});
  }
  const std::uint64_t seed = plan.seed + static_cast<std::uint64_t>(turn.first);
  arguments.insert(arguments.end(), {"--seed", std::to_string(seed), "--runs", std::to_string(turn.runs), "--out",
                                     (folder / batch.name).string()});
  const int last = turn.first + turn.runs;
  return {.name = fmt::format(
              "{}/{}, {} of {}", study.id, batch.name,
              turn.runs == 1 ? fmt::format("run {}", last) : fmt::format("runs {} to {}", turn.first + 1, last),
              batch.runs),
          .command = "exec " + command_of(app_of(study, plan).program, arguments),
          .seconds = batch.seconds * turn.runs,
          .stage = stage_of(batch)};
}

// Threads that take one job after the other.
class Crew {
 public:
  Crew(const std::vector<const Job*>& jobs, std::string log, const std::function<void(const std::string&)>& tell)
      : jobs_(jobs), log_(std::move(log)), tell_(tell) {
    for (const Job* job : jobs_) all_ += job->seconds;
  }

  Ran run(int at_a_time, const std::function<int()>& signal) {
    std::atomic<int> at_work = at_a_time;
    std::vector<std::thread> threads;
    threads.reserve(static_cast<std::size_t>(at_a_time));
    for (int i = 0; i < at_a_time; ++i) {
      threads.emplace_back([this, &at_work] {
        while (const Job* job = take()) work(*job);
        --at_work;
      });
    }
    Ran ran;
    while (at_work > 0) {
      std::this_thread::sleep_for(kLook);
      if (ran.signal != 0 || signal() == 0) continue;
      ran.signal = signal();
      stop();
    }
    for (std::thread& thread : threads) thread.join();
    ran.failed = failed_;
    return ran;
  }

 private:
  const Job* take() {
    const std::lock_guard lock(mutex_);
    return stopped_ || next_ == jobs_.size() ? nullptr : jobs_[next_++];
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    for (const pid_t process : processes_) ::kill(process, SIGTERM);
  }

  void work(const Job& job) {
    std::error_code error;
    if (!job.writes.empty()) {
      std::filesystem::create_directories(std::filesystem::path(job.writes).parent_path(), error);
      std::filesystem::remove(unfinished(job.writes), error);
    }
    // What is printed of a batch is in its files.
    const std::string command = fmt::format("echo $$; exec >/dev/null 2>>{}; {}", quoted(log_), job.command);
    std::FILE* pipe = popen(command.c_str(), "re");
    if (pipe == nullptr) return end(job, -1);
    int process = 0;
    const bool started = std::fscanf(pipe, "%d", &process) == 1;  // NOLINT(cert-err34-c): a shell's own number
    if (started) begin(process);
    int status = pclose(pipe);
    if (started) forget(process);
    if (status == 0 && !job.writes.empty()) {
      std::filesystem::rename(unfinished(job.writes), job.writes, error);
      if (error) status = -1;
    }
    end(job, status);
  }

  void begin(pid_t process) {
    const std::lock_guard lock(mutex_);
    processes_.insert(process);
    if (stopped_) ::kill(process, SIGTERM);
  }
  void forget(pid_t process) {
    const std::lock_guard lock(mutex_);
    processes_.erase(process);
  }

  void end(const Job& job, int status) {
    const std::lock_guard lock(mutex_);
    ++ended_;
    done_ += job.seconds;
    const bool well = status == 0;
    if (!well && stopped_) return;
    if (!well) failed_.push_back(job.name);
    tell_(fmt::format("[{:>3}/{}{}] {}{}", ended_, jobs_.size(), time_left(), job.name,
                      well ? "" : fmt::format(": FAILED, see the end of {}", log_)));
  }

  std::string time_left() const {
    const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double left = done_ > 0.0 ? passed * (all_ - done_) / done_ : 0.0;
    return left < 1.0      ? ""
           : left < 6000.0 ? fmt::format(", {:.0f} min left", left / 60.0)
                           : fmt::format(", {:.1f} h left", left / 3600.0);
  }

  const std::vector<const Job*>& jobs_;
  const std::string log_;
  const std::function<void(const std::string&)>& tell_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double all_ = 0.0;

  std::mutex mutex_;  // of what follows
  std::size_t next_ = 0;
  std::size_t ended_ = 0;
  double done_ = 0.0;
  bool stopped_ = false;
  std::set<pid_t> processes_;
  std::vector<std::string> failed_;
};

}  // namespace

Jobs make_jobs(const std::vector<Study>& studies, const Plan& plan) {
  Jobs jobs;
  std::vector<Turn> turns;
  for (const Study& study : studies) {
    if (!study.missing.empty()) continue;
    for (const Measurement& measurement : study.measurements) {
      std::error_code error;
      if (std::filesystem::exists(record_of(study, measurement, plan), error)) continue;
      jobs.measurements.push_back(measuring(study, measurement, plan));
    }
    for (const Batch& batch : study.batches) {
      const int size = std::max(1, static_cast<int>(kTurn / std::max(1.0, batch.seconds)));
      for (int first = 0; first < batch.runs; first += size) {
        turns.push_back({&study, &batch, first / size, first, std::min(size, batch.runs - first)});
      }
    }
  }
  // First the first turn of each batch, then the second of each.
  std::ranges::stable_sort(turns, {}, &Turn::number);
  for (const Turn& turn : turns) jobs.runs.push_back(running(turn, plan));
  return jobs;
}

std::string asking_what_is_in_common(const Study& study, const Batch& batch, const Plan& plan) {
  std::vector<std::string> arguments = arguments_of_batch(study, batch, plan);
  arguments.emplace_back("--in-common");
  return command_of(app_of(study, plan).program, arguments);
}

Ran run_jobs(const std::vector<Job>& jobs, int at_a_time, const std::string& log, const std::function<int()>& signal,
             const std::function<void(const std::string&)>& tell) {
  Ran ran;
  for (const Stage stage : {Stage::kVirtual, Stage::kLive, Stage::kCalibrated}) {
    std::vector<const Job*> these;
    for (const Job& job : jobs) {
      if (job.stage == stage) these.push_back(&job);
    }
    if (these.empty() || ran.signal != 0) continue;
    const Ran more = Crew(these, log, tell).run(stage == Stage::kLive ? 1 : at_a_time, signal);
    ran.signal = more.signal;
    ran.failed.insert(ran.failed.end(), more.failed.begin(), more.failed.end());
  }
  return ran;
}

}  // namespace ctn::case_studies
