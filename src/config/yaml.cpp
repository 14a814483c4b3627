#include "config/yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <exception>
#include <sstream>
#include <utility>

#include "base/text.h"
#include "config/text_check.h"

namespace ctn::config {
namespace {

constexpr std::size_t kDeepest = 16;

// What leaves the parser when the tree builder has seen enough.
struct Refused {
  Problem problem;
};

std::vector<std::string_view> split_lines(std::string_view text) {
  std::vector<std::string_view> lines;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

// Builds the tree from the parser's events. `stack_` holds the sequences and maps that are still open; in a map, keys
// and values take turns.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(std::string_view text, std::string_view file) : lines_(split_lines(text)), file_(file) {}

  Value take_root() { return std::move(root_); }
  bool has_root() const { return has_root_; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (has_root_) refuse(mark, "a second document begins here", "keep one document a file: remove '---'");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    add(Value{ValueKind::kNull, "", false, false, place(mark), {}, {}}, mark);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    refuse(mark, "aliases (*name) have no place here", "write the value out");
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    Value value{ValueKind::kScalar, text, tag == "!", false, place(mark), {}, {}};
    value.verbatim = !value.quoted && stands_at(value.place, text);
    add(std::move(value), mark);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(ValueKind::kSequence, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(ValueKind::kMap, mark, tag, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    Value value;
    bool has_key = false;  // the last entry of a map waits for its value
  };

  Place place(const YAML::Mark& mark) const { return {file_, mark.line + 1, mark.column + 1}; }

  [[noreturn]] void refuse(const YAML::Mark& mark, std::string what, std::string hint) const {
    throw Refused{{place(mark), "", std::move(what), std::move(hint)}};
  }
  void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor != 0) refuse(mark, "anchors (&name) have no place here", "write the value out wherever it is needed");
  }
  // "?" is a plain scalar or collection, "!" a quoted scalar; anything else was written.
  void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (!tag.empty() && tag != "?" && tag != "!") refuse(mark, "tags (!name) have no place here", "remove the tag");
  }

  bool stands_at(const Place& at, std::string_view text) const {
    const auto line = static_cast<std::size_t>(at.line - 1);
    const auto column = static_cast<std::size_t>(at.column - 1);
    return line < lines_.size() && column <= lines_[line].size() && lines_[line].substr(column).starts_with(text);
  }

  void open(ValueKind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    if (stack_.size() == kDeepest) refuse(mark, fmt::format("more than {} levels deep", kDeepest), "nest less");
    if (!stack_.empty() && expects_key(stack_.back())) refuse_key(mark);
    stack_.push_back({Value{kind, "", false, false, place(mark), {}, {}}, false});
  }

  void close() {
    Value value = std::move(stack_.back().value);
    stack_.pop_back();
    attach(std::move(value));
  }

  static bool expects_key(const Open& open) { return open.value.kind == ValueKind::kMap && !open.has_key; }

  [[noreturn]] void refuse_key(const YAML::Mark& mark) const {
    refuse(mark, "this key is no plain text", "write key: value");
  }

  void add(Value value, const YAML::Mark& mark) {
    if (!stack_.empty() && expects_key(stack_.back())) {
      if (value.kind != ValueKind::kScalar) refuse_key(mark);
      if (!value.quoted && value.text == "<<") refuse(mark, "merge keys (<<) have no place here", "write the keys out");
      stack_.back().value.entries.push_back({std::move(value.text), std::move(value.place), Value{}});
      stack_.back().has_key = true;
      return;
    }
    attach(std::move(value));
  }

  void attach(Value value) {
    if (stack_.empty()) {
      root_ = std::move(value);
      has_root_ = true;
      return;
    }
    Open& parent = stack_.back();
    if (parent.value.kind == ValueKind::kSequence) {
      parent.value.items.push_back(std::move(value));
      return;
    }
    Entry& entry = parent.value.entries.back();
    // The library's mark of a missing value is wherever the next thing stands.
    if (value.kind == ValueKind::kNull) value.place = entry.place;
    entry.value = std::move(value);
    parent.has_key = false;
  }

  std::vector<std::string_view> lines_;
  std::string file_;
  std::vector<Open> stack_;
  Value root_;
  bool has_root_ = false;
};

Error syntax_error(const YAML::Exception& exception, std::string_view file, std::string_view help) {
  Place place{std::string(file), 1, 1};
  if (!exception.mark.is_null()) place = {std::string(file), exception.mark.line + 1, exception.mark.column + 1};
  return {ErrorKind::kCaller,
          {{place, "", "this is not YAML: " + exception.msg, fmt::format("see {} for examples", help)}}};
}

}  // namespace

std::string describe(const Value& value) {
  switch (value.kind) {
    case ValueKind::kNull:
      return "nothing";
    case ValueKind::kScalar:
      return quote(value.text);
    case ValueKind::kSequence:
      return "a list";
    case ValueKind::kMap:
      return "a map";
  }
  return "";
}

Result<Value> parse_yaml(std::string_view text, std::string_view file, std::string_view help) {
  const std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  if (auto problem = check_text(text, file)) return Error(ErrorKind::kCaller, {std::move(*problem)});
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    TreeBuilder builder(text, file);
    while (parser.HandleNextDocument(builder)) {
    }
    if (Value root = builder.take_root(); root.kind != ValueKind::kNull) return root;
    return Error(ErrorKind::kCaller,
                 {{{std::string(file), 1, 1}, "", "the file is empty", fmt::format("see {}", help)}});
  } catch (const Refused& refused) {
    return Error(ErrorKind::kCaller, {refused.problem});
  } catch (const YAML::Exception& exception) {
    return syntax_error(exception, file, help);
  } catch (const std::exception& exception) {
    return Error(ErrorKind::kCaller, {{{std::string(file), 1, 1}, "", "this is not YAML", exception.what()}});
  }
}

}  // namespace ctn::config
