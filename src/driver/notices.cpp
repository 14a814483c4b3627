#include "driver/notices.h"

#include <cstddef>
#include <optional>
#include <utility>

namespace ctn::driver {
namespace {

// For the snapshot, and for a callback that blocks; the record has all.
constexpr std::size_t kKept = 1000;

void keep(std::deque<std::string>& texts, const std::string& text) {
  texts.push_back(text);
  if (texts.size() > kKept) texts.pop_front();
}

}  // namespace

void Notices::add(record::Notice notice) {
  const std::string text = notice.kind + ": " + notice.detail;
  {
    const std::lock_guard lock(mutex_);
    keep(newest_, text);
    if (on_added_) keep(undelivered_, text);
    if (recorded_) unrecorded_.push_back(std::move(notice));
  }
  if (on_added_) on_added_();
}

std::vector<std::string> Notices::newest() const {
  const std::lock_guard lock(mutex_);
  return {newest_.begin(), newest_.end()};
}

void Notices::deliver(const Callback& on_notice) {
  const auto next = [this]() -> std::optional<std::string> {
    const std::lock_guard lock(mutex_);
    if (undelivered_.empty()) return std::nullopt;
    std::string text = std::move(undelivered_.front());
    undelivered_.pop_front();
    return text;
  };
  while (const std::optional<std::string> text = next()) on_notice(*text);
}

std::vector<record::Notice> Notices::take_unrecorded() {
  const std::lock_guard lock(mutex_);
  return std::exchange(unrecorded_, {});
}

}  // namespace ctn::driver
