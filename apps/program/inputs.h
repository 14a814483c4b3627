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

// By name, of the files at these paths. Files that cannot be read are left out, as empty paths are: who opens them says
// so.
std::map<std::string, std::string> fingerprints_of(const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace ctn::program
