// What the programs that this process started have started in turn, for ending all of it.
//
// A process whose parent ends is given to the next of its ancestors that adopts orphans, so once this one does, nothing
// below it is lost sight of, also what has put itself into the background. Guardians (guardian.h) are not counted: they
// are to outlive this process.
//
// Thread safety: pure functions of the system; adopt_orphans() is for the whole process.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "os/linux/files.h"
#include "os/os.h"

namespace ctn::os {

// From now on. False: the system does not do that.
bool adopt_orphans();
// Collects the ends of adopted ones, which would stay in the list of processes else; `own` are left to their owners.
void reap_orphans(const std::vector<ProcessId>& own);

// All below this process that have not ended.
std::vector<ProcessId> descendants(const LinuxRoots& roots = {});

// The parent in the text of /proc/PID/stat, and the state's letter.
struct Parentage {
  ProcessId parent{};
  char state = ' ';
  bool guardian = false;
};
std::optional<Parentage> parse_parentage(std::string_view stat);

}  // namespace ctn::os
