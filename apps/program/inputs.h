// What the files hold that a run depends on, told apart by fingerprints. Runs of a batch that goes on must be of the
// same contents, and an outcome is to tell of what it is; a path tells neither.
//
// Thread safety: pure, but for what is read.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ctn::program {

// As text.
std::string fingerprint_of(std::string_view contents);
// Its first half, for names of files and folders.
std::string short_fingerprint_of(std::string_view contents);

// Of several files as one. Those that cannot be read count as empty ones.
std::string fingerprint_of_files(const std::vector<std::string>& paths);

// By name, of the files at these paths. Files that cannot be read are left out, as empty paths are: who opens them says
// so.
std::map<std::string, std::string> fingerprints_of(const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace ctn::program
