// Many runs of a program that differ in their seed alone. With a folder, the JSON document of each run is a file there,
// `run-SEED.json`, which appears whole or not at all; runs of which there is a file are not run again, so a batch that
// was stopped goes on. Runs with and without real-time levels (`real_time`, which a run in life says) are not mixed.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "catan/result.h"

namespace ctn::program {

// The name of a run's file: "run-7.json".
std::string file_of_run(std::uint64_t seed);

struct Seeds {
  std::uint64_t first = 1;
  int count = 1;
};

// What a run printed.
struct Document {
  std::string text;
  double took_seconds = 0.0;
  int signal = 0;  // that ended it early; 0: none
};

struct BatchSteps {
  std::function<Result<Document>(std::uint64_t seed)> run;
  // A document of a run, from `file` or from a run that has just ended, in the order of seeds. Returns a few words on
  // the run. Errors: it is none, or one of another run.
  std::function<Result<std::string>(const std::string& text, const std::string& file, std::uint64_t seed)> take;
  std::function<void(const std::string& line)> tell;  // of each run
};

// Returns the signal that has ended the batch early; 0: none. `folder`: empty: documents are not kept. Errors: those of
// the steps; a folder or a file that cannot be written (kEnvironment); a run that differs from the others in
// `real_time`, which is then not stored (kCaller).
Result<int> run_batch(Seeds seeds, const std::string& folder, const BatchSteps& steps);

// The same for runs with `options` of an app, of which `seed`, `runs` and `out` say what is run. `run_one(options)` is
// one of them: a Result of an outcome, of which to_json() in the app's namespace makes the document. `take(text, file,
// options)`: as in BatchSteps, with the options of that run.
template <class Options, class RunOne, class Take>
Result<int> run_batch(const Options& options, const RunOne& run_one, const Take& take,
                      const std::function<void(const std::string&)>& tell) {
  const auto with_seed = [&options](std::uint64_t seed) {
    Options one = options;
    one.seed = seed;
    return one;
  };
  BatchSteps steps;
  steps.run = [&](std::uint64_t seed) -> Result<Document> {
    const auto outcome = run_one(with_seed(seed));
    if (!outcome) return outcome.error();
    return Document{to_json(*outcome), outcome->took_seconds, outcome->signal};
  };
  steps.take = [&](const std::string& text, const std::string& file, std::uint64_t seed) {
    return take(text, file, with_seed(seed));
  };
  steps.tell = tell;
  return run_batch(Seeds{options.seed, options.runs}, options.out, steps);
}

// The same, collected in a Batch of the app: what it was asked for, its runs, and the signal. `read(text, file,
// options)`: the stored run that a document is. `words_on(run)`: a few words.
template <class Batch, class Options, class RunOne, class Read, class WordsOn>
Result<Batch> collect_batch(const Options& options, const RunOne& run_one, const Read& read, const WordsOn& words_on,
                            const std::function<void(const std::string&)>& tell) {
  Batch batch{options, {}, 0};
  const auto take = [&](const std::string& text, const std::string& file, const Options& one) -> Result<std::string> {
    auto run = read(text, file, one);
    if (!run) return run.error();
    batch.runs.push_back(std::move(run).value());
    return words_on(batch.runs.back());
  };
  const auto ended = run_batch(options, run_one, take, tell);
  if (!ended) return ended.error();
  batch.signal = *ended;
  return batch;
}

// Whether the JSON document `text` is of a run with the options that `identity`, a JSON object, says: each of its
// members is in the document, and has the same value. Errors (kCaller): it is not; it is none, or has no figures.
Status check_document(const std::string& text, const std::string& file, const std::string& identity);

}  // namespace ctn::program
