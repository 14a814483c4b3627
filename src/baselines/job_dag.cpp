#include "baselines/job_dag.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/numbers.h"

namespace ctn::baselines {
namespace {

constexpr double kTimeRounding = 1e-9;

long floor_divide(long a, long b) { return a / b - (a % b != 0 && a < 0 ? 1 : 0); }

int hyperperiod_of(std::span<const DagTask> tasks) {
  int longest = 1;
  for (const DagTask& task : tasks) longest = std::max(longest, task.every);
  return longest;
}

class Scheduling {
 public:
  Scheduling(std::span<const DagTask> tasks, std::span<const DagEdge> edges)
      : tasks_(tasks), hyperperiod_(hyperperiod_of(tasks)) {
    int cores = 0;
    for (std::size_t task = 0; task < tasks.size(); ++task) {
      first_.push_back(static_cast<int>(jobs_.size()));
      cores = std::max(cores, tasks[task].core + 1);
      for (int at = 0; at < hyperperiod_; at += tasks[task].every) {
        Job& job = jobs_.emplace_back();
        job.task = static_cast<int>(task);
        job.release = at;
        job.left = tasks[task].cost;
      }
    }
    ready_.resize(static_cast<std::size_t>(cores));
    for (const DagEdge& edge : edges) connect(edge);
    for (int job = 0; job < static_cast<int>(jobs_.size()); ++job) by_release_.push_back(job);
    std::stable_sort(by_release_.begin(), by_release_.end(),
                     [&](int a, int b) { return at(a).release < at(b).release; });
  }

  std::optional<DagSchedule> run() {
    std::size_t released = 0;
    std::size_t done = 0;
    double now = 0.0;
    while (done < jobs_.size()) {
      for (; released < by_release_.size() && at(by_release_[released]).release <= now + kTimeRounding; ++released) {
        Job& job = at(by_release_[released]);
        job.released = true;
        if (job.waits_for == 0) make_ready(by_release_[released]);
      }
      const double next = released < by_release_.size() ? at(by_release_[released]).release : kInfinity;
      const double until = std::min(next, begin_and_see_end(now));
      if (until == kInfinity) return std::nullopt;  // they wait for each other
      for (const int running : running_) {
        at(running).left -= until - now;
        if (at(running).left > kTimeRounding) continue;
        if (!finish(running, until)) return std::nullopt;
        ++done;
      }
      now = until;
    }
    return made();
  }

 private:
  struct Job {
    int task = 0;
    double release = 0.0;
    double left = 0.0;
    double begin = -1.0;
    double end = 0.0;
    int waits_for = 0;
    bool released = false;
    std::vector<int> successors;
  };

  Job& at(int job) { return jobs_[static_cast<std::size_t>(job)]; }
  const DagTask& task_of(int job) { return tasks_[static_cast<std::size_t>(at(job).task)]; }

  void connect(const DagEdge& edge) {
    const int runs = hyperperiod_ / tasks_[static_cast<std::size_t>(edge.to)].every;
    for (int number = 0; number < runs; ++number) {
      const long used = used_run(tasks_, edge, number);
      if (used < 0) continue;  // it ended before this hyperperiod began
      const int from = first_[static_cast<std::size_t>(edge.from)] + static_cast<int>(used);
      const int to = first_[static_cast<std::size_t>(edge.to)] + number;
      at(from).successors.push_back(to);
      ++at(to).waits_for;
    }
  }

  void make_ready(int job) { ready_[static_cast<std::size_t>(task_of(job).core)].emplace(-task_of(job).priority, job); }

  // Chooses the jobs that run from now on; when the first of them would end.
  double begin_and_see_end(double now) {
    double earliest = kInfinity;
    running_.clear();
    for (const auto& ready : ready_) {
      if (ready.empty()) continue;
      running_.push_back(ready.begin()->second);
      Job& job = at(running_.back());
      if (job.begin < 0.0) job.begin = now;
      earliest = std::min(earliest, now + std::max(0.0, job.left));
    }
    return earliest;
  }

  bool finish(int number, double now) {
    Job& job = at(number);
    job.end = now;
    ready_[static_cast<std::size_t>(task_of(number).core)].erase({-task_of(number).priority, number});
    for (const int successor : job.successors) {
      if (--at(successor).waits_for == 0 && at(successor).released) make_ready(successor);
    }
    return now <= job.release + task_of(number).every + kTimeRounding * hyperperiod_;
  }

  DagSchedule made() const {
    DagSchedule schedule;
    schedule.hyperperiod = hyperperiod_;
    schedule.runs.resize(tasks_.size());
    for (const Job& job : jobs_) schedule.runs[static_cast<std::size_t>(job.task)].push_back({job.begin, job.end});
    return schedule;
  }

  std::span<const DagTask> tasks_;
  const int hyperperiod_;
  std::vector<Job> jobs_;  // task by task
  std::vector<int> first_;
  std::vector<int> by_release_;
  std::vector<std::set<std::pair<int, int>>> ready_;  // by core: (-priority, job)
  std::vector<int> running_;                          // jobs, one a core
};

}  // namespace

DagRun DagSchedule::run(std::size_t task, long number) const {
  const auto count = static_cast<long>(runs[task].size());
  const long cycle = floor_divide(number, count);
  DagRun found = runs[task][static_cast<std::size_t>(number - cycle * count)];
  const double shift = static_cast<double>(cycle) * hyperperiod;
  found.begin += shift;
  found.end += shift;
  return found;
}

std::size_t runs_of(std::span<const DagTask> tasks) {
  std::size_t runs = 0;
  for (const DagTask& task : tasks) runs += static_cast<std::size_t>(hyperperiod_of(tasks) / task.every);
  return runs;
}

std::optional<DagSchedule> schedule_dag(std::span<const DagTask> tasks, std::span<const DagEdge> edges) {
  return Scheduling(tasks, edges).run();
}

long used_run(std::span<const DagTask> tasks, const DagEdge& edge, long number) {
  const long release = number * tasks[static_cast<std::size_t>(edge.to)].every;
  return floor_divide(release - edge.delay, tasks[static_cast<std::size_t>(edge.from)].every);
}

DagLatency chain_latency(std::span<const DagTask> tasks, const DagSchedule& schedule, int first,
                         std::span<const DagEdge> row) {
  const auto last = static_cast<std::size_t>(row.empty() ? first : row.back().to);
  const auto source_of = [&](long number) {
    for (std::size_t i = row.size(); i-- > 0;) number = used_run(tasks, row[i], number);
    return number;
  };
  DagLatency worst;
  const auto outputs = static_cast<long>(schedule.runs[last].size());
  for (long number = 0; number < outputs; ++number) {
    const long source = source_of(number);
    const long before = source_of(number - 1);
    const double end = schedule.run(last, number).end;
    worst.age = std::max(worst.age, end - schedule.run(static_cast<std::size_t>(first), source).begin);
    if (source == before) continue;
    worst.reaction = std::max(worst.reaction, end - schedule.run(static_cast<std::size_t>(first), before).begin);
  }
  return worst;
}

}  // namespace ctn::baselines
