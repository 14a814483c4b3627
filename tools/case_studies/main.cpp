// catan_case_studies: runs the case studies under all schedulers, and writes what came out as one page.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "alike.h"
#include "experiments/host.h"
#include "experiments/shell.h"
#include "jobs.h"
#include "map_file.h"
#include "map_picture.h"
#include "page.h"
#include "page/page.h"
#include "program/command_line.h"
#include "program/inputs.h"
#include "program/terminal.h"
#include "program/text_file.h"
#include "studies.h"
#include "world/world_file.h"

namespace ctn::case_studies {
namespace {

constexpr const char* kProgram = "catan_case_studies";

struct Options {
  std::string out;
  std::string navigation;  // the programs
  std::string vr;
  std::uint64_t seed = 1001;
  int jobs = 0;
  std::vector<std::string> only;   // studies; empty: all
  std::vector<std::string> model;  // of a YOLO; empty: the people detector
  bool no_life = false;
  bool page = false;
  Setting setting;
};

// In the build tree, seen from this program's folder; or where both were installed to.
std::string find_program(const std::string& in_build, const std::string& name) {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const auto built = (folder / in_build / name).lexically_normal();
  return std::filesystem::exists(built, error) ? built.string() : (folder / name).string();
}

const std::string& program_of(const Options& options, const std::string& app) {
  return app == "vr" ? options.vr : options.navigation;
}

// The name of the folder of a program's runs: runs of one build are not mixed with those of another, which may drive
// otherwise. Empty: it cannot be read.
std::string folder_of_build(const std::string& program) {
  const std::string text = program::text_of_file(program).value_or("");
  return text.empty() ? std::string() : "runs-" + program::short_fingerprint_of(text);
}

std::string log_of(const Options& options) { return (std::filesystem::path(options.out) / "programs.log").string(); }

// On its standard output; empty: it failed.
std::string printed_by(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "re");
  if (pipe == nullptr) return {};
  std::string printed;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) printed += static_cast<char>(c);
  return pclose(pipe) == 0 ? printed : std::string();
}

Status make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error::environment(folder.string() + " cannot be made", "name another folder with --out");
  return Done{};
}

// Of the studies that can be run here. --out is there afterwards, whatever they are.
Result<std::map<std::string, App>> apps_of(const Options& options, const std::vector<Study>& studies) {
  if (Status made = make_folder(options.out); !made) return made.error();
  std::map<std::string, App> apps;
  for (const Study& study : studies) {
    if (!study.missing.empty() || apps.contains(study.program)) continue;
    const std::string& program = program_of(options, study.program);
    const std::string name = folder_of_build(program);
    if (name.empty()) return Error::caller(program + " cannot be read", "name another program");
    const App app{program, std::filesystem::path(options.out) / name};
    if (Status made = make_folder(app.folder); !made) return made.error();
    apps[study.program] = app;
  }
  return apps;
}

void tell_of_other_builds(const Options& options) {
  const std::vector<std::string> used{folder_of_build(options.navigation), folder_of_build(options.vr)};
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(options.out, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("runs-") || std::ranges::find(used, name) != used.end()) continue;
    fmt::print(stderr, "{}: {} has runs of another build, which are not used\n", kProgram, entry.path().string());
  }
}

// In whole sentences; empty: it can be. What the headset draws with is looked for while it runs, so it runs for a
// moment, unless nothing is to be run.
std::string why_no_headset(const Options& options) {
  std::error_code error;
  if (!std::filesystem::exists(options.vr, error)) return fmt::format("{} is not there.", options.vr);
  if (options.page) return {};
  const std::string command =
      experiments::quoted(options.vr) + " --virtual --seconds 1 --scheduler default 2>&1 >/dev/null";
  std::FILE* pipe = popen(command.c_str(), "re");
  if (pipe == nullptr) return options.vr + " cannot be started.";
  std::string said;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) said += c == '\n' ? ' ' : static_cast<char>(c);
  if (pclose(pipe) == 0 || program::signal_so_far() != 0) return {};
  return "It cannot be run here: " + (said.empty() ? options.vr + " fails, and says nothing." : said);
}

Result<std::vector<Map>> maps_of(const Options& options) {
  std::vector<Map> maps;
  for (const std::string& map : {options.setting.map1, options.setting.map2}) {
    const auto world = navigation::world::read_world(file_of_map(map, options.navigation));
    if (!world) return world.error();
    maps.push_back({fmt::format("{}: {}. Blue: the robot{}{}.", map.size() == 1 ? "Map " + map : map, world->name,
                                world->goal ? "; green: its goal" : ", which explores",
                                world->movers.empty() ? "" : "; orange: what moves"),
                    map_picture(*world)});
  }
  return maps;
}

Result<std::vector<Study>> chosen(const Options& options) {
  std::vector<Study> studies = make_studies(options.setting);
  for (const std::string& name : options.only) {
    if (std::ranges::find(studies, name, &Study::id) != studies.end()) continue;
    std::string names;
    for (const Study& study : studies) names += (names.empty() ? "" : ", ") + study.id;
    return Error::caller(fmt::format("--only: there is no study '{}'", name), "there are " + names);
  }
  if (!options.only.empty()) {
    std::erase_if(studies,
                  [&](const Study& study) { return std::ranges::find(options.only, study.id) == options.only.end(); });
  }
  return studies;
}

// Those of the runs that are there which are what the batch asks for. `log`: where the program's messages go.
Alike taken_of(std::vector<StoredRun> runs, const std::string& asking, const std::string& log) {
  if (runs.empty()) return {};
  const auto asked = parse_options(printed_by(asking + " 2>>" + experiments::quoted(log)));
  if (asked) return alike(std::move(runs), *asked);
  return {{}, "no run is taken: the program does not say what they have in common; see the end of " + log};
}

Result<Results> gather(const Options& options, std::vector<Study> studies, const std::map<std::string, App>& apps) {
  Results results{.host = {},
                  .quick = options.setting.quick,
                  .seed = options.seed,
                  .maps = {},
                  .failed = {},
                  .left_out = {},
                  .studies = {}};
  for (Study& study : studies) {
    Runs runs;
    if (study.missing.empty()) {
      const std::filesystem::path folder = apps.at(study.program).folder / study.id;
      for (const Batch& batch : study.batches) {
        auto read = read_runs(folder / batch.name, options.seed, batch.runs);
        if (!read) return read.error();
        Alike taken = taken_of(std::move(read).value(), asking_what_is_in_common(study, batch, {apps, options.seed}),
                               log_of(options));
        runs[batch.name] = std::move(taken.runs);
        if (taken.left_out.empty()) continue;
        results.left_out.push_back(fmt::format("{}: {}", (folder / batch.name).string(), taken.left_out));
      }
    }
    results.studies.push_back({std::move(study), std::move(runs)});
  }
  return results;
}

// Measurements first, since the others need them.
Ran run_all(const std::vector<Study>& studies, const Options& options, const std::map<std::string, App>& apps) {
  const Jobs jobs = make_jobs(studies, {apps, options.seed});
  const std::string log = log_of(options);
  std::ofstream(log, std::ios::trunc).flush();
  const auto tell = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
  Ran ran = run_jobs(jobs.measurements, options.jobs, log, program::signal_so_far, tell);
  if (ran.signal != 0) return ran;
  Ran rest = run_jobs(jobs.runs, options.jobs, log, program::signal_so_far, tell);
  rest.failed.insert(rest.failed.begin(), ran.failed.begin(), ran.failed.end());
  return rest;
}

Result<std::vector<Study>> studies_to_run(Options& options, const experiments::Host& host) {
  options.setting.cpu = host.cpu_sets.front().front();
  if (options.no_life) {
    options.setting.no_life = "It was not asked for (--no-life).";
  } else if (!host.no_real_time.empty()) {
    options.setting.no_life = "Real-time levels may not be set here: " + host.no_real_time;
  } else if (host.cpu_sets.size() < 2) {
    options.setting.no_life = "It takes two CPUs: one for the nodes, and one for the world.";
  }
  auto studies = chosen(options);
  if (!studies) return studies.error();
  const bool with_headset = std::ranges::find(*studies, "vr", &Study::program) != studies->end();
  if (const std::string why = with_headset ? why_no_headset(options) : ""; !why.empty()) {
    leave_out(*studies, "vr", why);
    fmt::print(stderr, "{}: the studies of the headset are left out. {}\n", kProgram, why);
  }
  return studies;
}

int run(Options& options) {
  const auto host = experiments::look_at_host(options.navigation);
  if (!host) return program::fail(kProgram, host.error());
  auto studies = studies_to_run(options, *host);
  if (!studies) return program::fail(kProgram, studies.error());
  const auto apps = apps_of(options, *studies);
  if (!apps) return program::fail(kProgram, apps.error());
  auto maps = apps->contains("navigation") ? maps_of(options) : Result<std::vector<Map>>(std::vector<Map>{});
  if (!maps) return program::fail(kProgram, maps.error());
  tell_of_other_builds(options);

  Ran ran;
  if (!options.page) ran = run_all(*studies, options, *apps);
  auto results = gather(options, std::move(studies).value(), *apps);
  if (!results) return program::fail(kProgram, results.error());
  results->host = host->facts;
  results->failed = ran.failed;
  results->maps = std::move(maps).value();
  const auto page = render_page(*results);
  if (!page) return program::fail(kProgram, page.error());
  const std::string file = (std::filesystem::path(options.out) / "report.html").string();
  if (Status saved = page::save(*page, file); !saved) return program::fail(kProgram, saved.error());
  const int code = program::print(to_text(*results) + fmt::format("\nPage: {}\n", file), ran.signal);
  return code == 0 && !(ran.failed.empty() && results->left_out.empty()) ? program::kFailure : code;
}

}  // namespace
}  // namespace ctn::case_studies

int main(int argc, char** argv) {
  using namespace ctn;
  case_studies::Options options;
  options.navigation = case_studies::find_program("../../apps/navigation/run", "navigation");
  options.vr = case_studies::find_program("../../apps/vr/run", "vr");
  options.jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  CLI::App app("Runs the case studies under all schedulers, in virtual time and in life, and writes one page.",
               case_studies::kProgram);
  app.add_option("--out", options.out, "folder for report.html and the runs")
      ->default_str("out/case-studies, with --quick out/case-studies-quick");
  app.add_flag("--quick", options.setting.quick, "few and short runs: ten minutes on two cores, not a night");
  app.add_option("--only", options.only, "only these studies, by the names of their folders");
  app.add_option("--runs", options.setting.max_runs, "at most so many runs a scheduler and study")
      ->check(CLI::Range(2, 100000))
      ->default_str("as many as each study needs");
  app.add_option("--seconds", options.setting.max_seconds, "no run lasts longer, in its own time")
      ->check(program::within(1.0, 86400.0))
      ->default_str("as long as each study needs");
  app.add_option("--seed", options.seed, "of each scheduler's first run")
      ->check(CLI::Range(1, 1000000000))
      ->capture_default_str();
  app.add_option("--jobs", options.jobs, "runs at a time")->check(CLI::Range(1, 1024))->default_str("the CPUs");
  app.add_option("--map1", options.setting.map1, "another world with a goal, in place of map 1")->type_name("FILE");
  app.add_option("--map2", options.setting.map2, "another world to be explored, in place of map 2")->type_name("FILE");
  app.add_option("--model", options.model, "a YOLO, FILE.cfg and FILE.weights, in place of OpenCV's people detector")
      ->type_name("FILE")
      ->expected(2, 3);
  app.add_flag("--no-life", options.no_life, "leave out what takes real time");
  app.add_flag("--page", options.page, "run nothing: draw the page of the runs that are there");
  app.add_option("--program", options.navigation, "the navigation program")->default_str("beside this one");
  app.add_option("--vr-program", options.vr, "the vr program")->default_str("beside this one");
  app.footer(
      "\nRun again, it goes on where it was stopped.\nexit codes: 0 done, 1 something could not be run, 2 a mistake, "
      "128 "
      "+ signal number when interrupted (the page has what was there)\n");
  if (const auto leave = program::parse(app, argc, argv)) return program::print(*leave);
  if (options.out.empty()) options.out = options.setting.quick ? "out/case-studies-quick" : "out/case-studies";
  if (!options.model.empty()) {
    options.setting.detector = {"--detector", "yolo", "--model"};
    options.setting.detector.insert(options.setting.detector.end(), options.model.begin(), options.model.end());
  }
  program::remember_signals();
  return case_studies::run(options);
}
