// Files that are there whole or not at all. One is written beside its place, as NAME.unfinished, and gets its name when
// it is finished: whoever is interrupted leaves nothing under the name. What a program that was killed has left beside
// it is taken over by the next that writes the file; while one writes it, another is refused.
//
// A place that is no file, but a device or a pipe, is written as it is.
//
// Thread safety: none; one owner.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "os/linux/descriptor.h"

namespace ctn::os {

class WholeFile {
 public:
  enum class Existing { kStays, kIsReplaced };

  // kCaller: there is such a file, and it is to stay; another program writes it. kEnvironment: it cannot be made.
  static Result<std::unique_ptr<WholeFile>> create(const std::string& path, Existing existing);
  // What was written is gone, unless it was finished.
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  Status write(std::string_view bytes);
  // Gives all of them their names, or none. No signal comes between. (Where several replace files, what was replaced
  // stays so.) Errors: as of create(), where there is such a file by now.
  static Status finish(const std::vector<std::unique_ptr<WholeFile>>& files);

 private:
  WholeFile(std::string path, std::string unfinished, Existing existing, Descriptor file)
      : path_(std::move(path)), unfinished_(std::move(unfinished)), existing_(existing), file_(std::move(file)) {}
  static Result<std::unique_ptr<WholeFile>> open_as_it_is(const std::string& path);
  Status give_name();
  void take_name_back();

  std::string path_;
  std::string unfinished_;  // empty: it has its name
  Existing existing_;
  Descriptor file_;  // locked
};

// Writes a whole file, in place of one that is there. Errors: as of WholeFile.
Status replace_file(const std::string& path, std::string_view bytes);

}  // namespace ctn::os
