// What a program tells on a file that may not take it for a long time, or never (a pipe that nobody reads, a terminal
// that is stopped), while the program has more to do than to tell it: write() does not wait. A thread writes, and
// sleeps while there is nothing to be written. Where the file takes nothing, texts are kept; where there are too many
// of them, later ones are lost, and counted, which is told in their place once the file takes some again.
//
// A write that waits can neither be ended nor waited for: the thread is left to itself then, and ends with the process.
//
// Thread safety: every call from any thread; the destructor from the last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/time.h"

namespace ctn::os {

class LogOutput {
 public:
  // What is written in place of so many texts that were lost.
  using TellLost = std::function<std::string(std::uint64_t texts)>;
  // Texts that are kept at most.
  static constexpr std::size_t kKept = 1000;

  // `file`: a descriptor that is open for as long as the process runs.
  LogOutput(int file, TellLost tell_lost);
  // Does not wait: what is not written yet is lost, but for a text that is being written.
  ~LogOutput();
  LogOutput(const LogOutput&) = delete;
  LogOutput& operator=(const LogOutput&) = delete;

  // Where the process may have no further thread it writes itself, and waits for the file.
  void write(std::string text);
  // Returns when all has been written, at the latest after so long. False: some has not.
  bool finish(Nanos at_most);

 private:
  class Writer;
  std::shared_ptr<Writer> writer_;  // the thread has it, too
};

}  // namespace ctn::os
