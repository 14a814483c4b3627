// Any bytes as a record: what catan report does with it ends in figures or in an error, never in a crash or a hang.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "page/page.h"
#include "page/story.h"
#include "record/reader.h"
#include "report/text.h"

namespace {

// One file in memory for the whole process: the reader takes a path, and disks are slow.
class File {
 public:
  File() {
    std::string pattern = "/dev/shm/record-fuzzer-XXXXXX";
    descriptor_ = mkstemp(pattern.data());
    if (descriptor_ < 0) std::abort();
    path_ = pattern;
  }
  ~File() {
    close(descriptor_);
    unlink(path_.c_str());
  }
  const std::string& path() const { return path_; }
  void set(const std::uint8_t* data, std::size_t size) const {
    if (ftruncate(descriptor_, 0) != 0) std::abort();
    if (pwrite(descriptor_, data, size, 0) != static_cast<ssize_t>(size)) std::abort();
  }

 private:
  int descriptor_ = -1;
  std::string path_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const File kFile;
  kFile.set(data, size);
  const auto record = ctn::record::Reader::open(kFile.path());
  if (!record) {
    if (record.error().message().empty()) std::abort();
    return 0;
  }
  const auto story = ctn::page::tell(*record, true);
  if (!story.ok() && story.error().message().empty()) std::abort();
  if (story.ok()) {
    (void)ctn::report::to_text(story->figures);
    (void)ctn::page::to_html({"record", *story});
  }
  return 0;
}
