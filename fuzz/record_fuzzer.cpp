// Any bytes as a record: what catan report does with it, --why included, ends in figures or in an error, never in a
// crash or a hang.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "page/page.h"
#include "page/story.h"
#include "record/reader.h"
#include "report/text.h"
#include "why/json.h"
#include "why/why.h"

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

// Parts follow each other and add up to the response, whatever the record says.
void check(const ctn::why::Analysis& analysis, const ctn::record::Reader& record) {
  for (const ctn::why::Response& response : analysis.worst) {
    ctn::TimePoint now = response.begin;
    for (const ctn::why::Part& part : response.parts) {
      if (part.begin != now || part.end <= part.begin) std::abort();
      now = part.end;
    }
    if (now != response.end || response.late != response.cause.has_value()) std::abort();
  }
  (void)ctn::why::to_json(analysis, record.app(), record.header().started);
}

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
  for (const std::size_t term : ctn::why::chains_of(record->app())) {
    const auto analysis = ctn::why::analyse(*record, term, {.worst = 20, .whole = true});
    if (!analysis.ok() && analysis.error().message().empty()) std::abort();
    if (analysis.ok()) check(*analysis, *record);
  }
  return 0;
}
