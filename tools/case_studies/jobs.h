// From studies to command lines, and running these: several at a time, those in real time one by one.
//
// A study's runs are in `FOLDER/STUDY/BATCH/run-SEED.json`, where the app's program itself keeps them: what is there it
// does not run again. Measurements are records, `FOLDER/STUDY/NAME-OF.catan`, where OF tells apart of what: another
// seed, another map, another detector is measured anew. Batches are run in turns of a few runs each, so that what is
// there after an early end compares all of them.
//
// A command is run by a shell that prints the number of its process first, so that it can be ended: the program stores
// what it has, and ends with 128 + the signal's number.
//
// Thread safety: make_jobs() is pure, but for looking which files are there, and what is in those that arguments name;
// run_jobs() starts threads of its own, and returns when they have ended.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/result.h"
#include "study.h"

namespace ctn::case_studies {

// In this order: those in real time when no others run, and then what is to cost as much as in these.
enum class Stage { kVirtual, kLive, kCalibrated };

struct Job {
  std::string name;     // "map2/catan, runs 3 to 4 of 20"
  std::string command;  // for a shell
  double seconds = 0;   // that its runs last at most
  Stage stage = Stage::kVirtual;
  std::string writes{};  // a file that the command writes as this name with ".unfinished" added; empty: none
};

// An app's program, and the folder of its studies' runs.
struct App {
  std::string program;
  std::filesystem::path folder;
};

struct Plan {
  std::map<std::string, App> apps;  // by name (Study::program): of each study that can be run here
  std::uint64_t seed = 1;           // of each batch's first run
};

// Those to be run first, which the others need; then the others. Studies that cannot be run here have none.
struct Jobs {
  std::vector<Job> measurements;
  std::vector<Job> runs;
};
Jobs make_jobs(const std::vector<Study>& studies, const Plan& plan);

// The command by which the program tells what the runs of a batch have in common (parse_options()).
std::string asking_what_is_in_common(const Study& study, const Batch& batch, const Plan& plan);

struct Ran {
  int signal = 0;                   // that ended it early; 0: none
  std::vector<std::string> failed;  // names of jobs
};

// `log`: where programs' messages go. `signal` is asked all the time whether to stop. `tell` is given a line a job.
// Jobs that fail do not stop the rest.
Ran run_jobs(const std::vector<Job>& jobs, int at_a_time, const std::string& log, const std::function<int()>& signal,
             const std::function<void(const std::string&)>& tell);

}  // namespace ctn::case_studies
