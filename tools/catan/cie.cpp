#include "cie.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "config/problems.h"
#include "config/read.h"
#include "os/class_names.h"
#include "plan_text.h"
#include "table.h"

namespace ctn::tool {
namespace {

using config::RosBinding;
using config::RosCallback;
using config::Value;
using config::ValueKind;

constexpr const char* kCiePage = "docs/ros2.md";
constexpr const char* kCieGroups = "callback_groups";
constexpr std::string_view kTemplateHint = "take the file as the executor's prerun node writes it";
constexpr int kMaxCiePriority = 99;  // Linux's

// What a thread of a callback group gets, and from which nodes.
struct CieSetting {
  int priority = 1;  // 0: an ordinary thread
  std::vector<int> cpus{};
  std::vector<std::string> reasons{};  // a comment each
};

// --- What the plan means ---

// One above all fixed priorities, for what runs by itself.
int priority_above(const plan::Plan& plan) {
  int highest = 1;
  for (const plan::CorePlan& core : plan.cores) {
    for (const plan::Member& member : core.members) highest = std::max(highest, member.priority);
  }
  return highest + 1;
}

// How far apart the executor calls each node, since it knows no rates: a timer's callback whenever that is due, all
// else with each output of the predecessor that gives most of them. By NodeId.
std::vector<Millis> cie_periods(const plan::Plan& plan, const graph::App& app,
                                const std::vector<RosBinding>& bindings) {
  std::vector<Millis> periods(app.graph.nodes().size(), Millis{0});
  for (const RosBinding& binding : bindings) {
    if (binding.callback.kind == RosCallback::Kind::kTimer) periods[binding.node.index()] = binding.callback.period;
  }
  for (const NodeId id : app.graph.topological_order()) {
    const graph::Node& node = app.graph.node(id);
    Millis& period = periods[id.index()];
    if (period > Millis{0}) continue;
    if (node.period) {
      period = *node.period;
      continue;
    }
    period = Millis{INFINITY};
    for (const NodeId predecessor : node.predecessors) {
      const Nanos outputs = app.graph.node(predecessor).output_period.value_or(Nanos{0});
      period = std::min(period, std::max<Millis>(periods[predecessor.index()], outputs));
    }
    // It is not known how often something comes from outside.
    if (std::isinf(period.count()) && node.subchain) period = plan::usual_timing(plan, *node.subchain).period;
  }
  return periods;
}

// The subchains whose core cannot keep up with the executor: what that calls of them, beside those above that it can
// keep up with, takes more of the core than plans may. At a fixed priority such a thread would never give way, until
// the kernel halts it for what is left of each second, and whatever else needs that CPU would wait for that. By
// SubchainId.
std::vector<bool> cie_overloads(const plan::Plan& plan, const graph::App& app,
                                const std::vector<RosBinding>& bindings) {
  const std::vector<Millis> periods = cie_periods(plan, app, bindings);
  const double usable = 1.0 - plan.slack;
  std::vector<bool> overloads;
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {  // those that own their cores
    const NodeId head = app.graph.subchains()[i].nodes.front();
    overloads.push_back(plan.subchains[i].execution / periods[head.index()] > usable);
  }
  for (const plan::CorePlan& core : plan.cores) {
    double demand = 0.0;
    for (const plan::Member& member : core.members) {  // the highest priority first
      const plan::SubchainPlan& planned = plan.subchains[member.subchain.index()];
      const NodeId head = app.graph.subchain(member.subchain).nodes.front();
      const double more = planned.slice / planned.share / periods[head.index()];
      overloads[member.subchain.index()] = demand + more > usable;
      if (demand + more <= usable) demand += more;
    }
  }
  return overloads;
}

CieSetting cie_setting(const plan::Plan& plan, const graph::App& app, NodeId node, const std::vector<int>& cpus,
                       bool overloads) {
  const std::optional<SubchainId> id = app.graph.node(node).subchain;
  const std::string& name = app.graph.node(node).name;
  if (!id) return {priority_above(plan), cpus, {fmt::format("{}: runs by itself, above all others", name)}};
  const plan::Member* const member = plan::member_of(plan, *id);
  CieSetting setting;
  for (const int core : plan.subchains[id->index()].cores) setting.cpus.push_back(cpus[static_cast<std::size_t>(core)]);
  std::string when;
  if (member != nullptr) {
    setting.priority = member->priority;
    when = fmt::format("{}, budget {}", trigger_text(*member, app), ms_text(member->budget));
  } else {
    when = fmt::format("alone on its core{}, every {}", setting.cpus.size() == 1 ? "" : "s",
                       ms_text(plan::usual_timing(plan, *id).period));
  }
  if (overloads) {
    setting.priority = 0;
    when += ", an ordinary thread: it is called more often than its CPU can run it";
  }
  setting.reasons.push_back(fmt::format("{}: subchain {}, {}", name, app.graph.subchain(*id).name, when));
  return setting;
}

// One thread runs the callbacks of both.
void add_setting(CieSetting& setting, const CieSetting& other) {
  setting.priority = std::max(setting.priority, other.priority);
  setting.cpus.insert(setting.cpus.end(), other.cpus.begin(), other.cpus.end());
  std::sort(setting.cpus.begin(), setting.cpus.end());
  setting.cpus.erase(std::unique(setting.cpus.begin(), setting.cpus.end()), setting.cpus.end());
  setting.reasons.insert(setting.reasons.end(), other.reasons.begin(), other.reasons.end());
}

// Whether the plan begins its runs at another time than messages and timers come: by time where it is called for each
// message, at another period than its timer's, or for some outputs only.
std::optional<std::string> cie_rate_note(const plan::Plan& plan, const graph::App& app, const RosBinding& binding) {
  constexpr double kAlike = 0.02;
  const std::optional<SubchainId> id = app.graph.node(binding.node).subchain;
  if (!id || app.graph.subchain(*id).nodes.front() != binding.node) return std::nullopt;
  const std::string& name = app.graph.node(binding.node).name;
  const plan::Member* const member = plan::member_of(plan, *id);
  const bool follows = member != nullptr && member->after;
  const Millis period = plan::usual_timing(plan, *id).period;
  const std::string planned = follows ? "for " + trigger_text(*member, app) : "every " + ms_text(period);
  if (binding.callback.kind == RosCallback::Kind::kTimer) {
    const Millis timer = binding.callback.period;
    if (!follows && std::abs(timer / period - 1.0) < kAlike) return std::nullopt;
    return fmt::format("{} is planned {}; the program's timer has {}", name, planned, ms_text(timer));
  }
  if (follows && member->after->every == 1) return std::nullopt;
  return fmt::format("{} is planned {}; the executor calls it {}", name, planned,
                     follows ? "for each message" : "whenever there is a message");
}

// --- IDs of callback groups ---

std::string cie_entry(const RosCallback& callback) {
  switch (callback.kind) {
    case RosCallback::Kind::kTopic:
      return fmt::format("Subscription({})", callback.name);
    case RosCallback::Kind::kService:
      return fmt::format("Service({})", callback.name);
    case RosCallback::Kind::kTimer:
      break;
  }
  return fmt::format("Timer({})", callback.period.count());
}

std::string cie_id_alone(const RosCallback& callback) { return callback.node + "@" + cie_entry(callback); }

bool cie_group_has(std::string_view id, const RosCallback& callback) {
  const std::string entry = cie_entry(callback);
  std::size_t at = id.find('@');
  if (id.substr(0, at) != callback.node) return false;
  while (at != std::string_view::npos) {
    const std::size_t next = id.find('@', at + 1);
    if (id.substr(at + 1, next == std::string_view::npos ? next : next - at - 1) == entry) return true;
    at = next;
  }
  return false;
}

// --- YAML ---

// As it can stand behind "key: " or in a list on one line.
std::string cie_scalar(const Value& value) {
  if (value.kind == ValueKind::kNull) return "~";
  if (!value.quoted && value.text.find_first_of(",[]{}") == std::string::npos) return value.text;
  std::string text = "\"";
  for (const char c : value.text) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

std::string cie_value(const Value& value) {
  if (value.kind != ValueKind::kSequence) return cie_scalar(value);
  std::vector<std::string> items;
  for (const Value& item : value.items) items.push_back(cie_scalar(item));
  return fmt::format("[{}]", fmt::join(items, ", "));
}

std::string cie_setting_text(const std::string& id, const CieSetting& setting) {
  std::string text;
  for (const std::string& reason : setting.reasons) text += fmt::format("  # {}\n", reason);
  return text + fmt::format("  - id: {}\n    affinity: [{}]\n    policy: {}\n    priority: {}\n", id,
                            fmt::join(setting.cpus, ", "),
                            setting.priority == 0 ? os::kOrdinaryClass : os::kFixedPriorityClass, setting.priority);
}

// Of the template, as it is.
std::string cie_map_text(const Value& map, const char* first, const char* next) {
  std::string text;
  for (const config::Entry& entry : map.entries) {
    text += fmt::format("{}{}: {}\n", text.empty() ? first : next, entry.key, cie_value(entry.value));
  }
  return text;
}

const Value* find_value(const Value& map, std::string_view key) {
  const auto found =
      std::find_if(map.entries.begin(), map.entries.end(), [&](const config::Entry& one) { return one.key == key; });
  return found == map.entries.end() ? nullptr : &found->value;
}

bool cie_is_flat(const Value& value) {
  return value.kind == ValueKind::kNull || value.kind == ValueKind::kScalar ||
         (value.kind == ValueKind::kSequence &&
          std::all_of(value.items.begin(), value.items.end(),
                      [](const Value& item) { return item.kind == ValueKind::kScalar; }));
}

void check_cie_map(const Value& map, const std::string& key, config::Problems& problems) {
  for (const config::Entry& entry : map.entries) {
    if (cie_is_flat(entry.value)) continue;
    problems.add(entry.value.place, config::join_key(key, entry.key),
                 "a number, a word or a list of these belongs here", std::string(kTemplateHint));
  }
}

void check_cie_threads(const Value& list, const std::string& key, config::Problems& problems) {
  if (list.kind == ValueKind::kNull || !config::expect(list, ValueKind::kSequence, key, kTemplateHint, problems))
    return;
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const std::string here = fmt::format("{}[{}]", key, i);
    const Value& item = list.items[i];
    if (!config::expect(item, ValueKind::kMap, here, kTemplateHint, problems)) continue;
    const Value* const id = find_value(item, "id");
    if (id == nullptr || id->kind != ValueKind::kScalar) {
      problems.add(item.place, here, "the id is missing", std::string(kTemplateHint));
    }
    check_cie_map(item, here, problems);
  }
}

std::string cie_head_text(const plan::Plan& plan, const graph::App& app) {
  return fmt::format(
      "# Threads of app {}, planned for {} core{}: response times at worst\n{}"
      "# Priorities and CPUs are the plan's. Rates are not in this file: comments say when runs are planned.\n",
      app.name, plan.cores.size(), plan.cores.size() == 1 ? "" : "s", [&] {
        std::string text;
        for (const plan::ChainPlan& chain : plan.chains) {
          text += fmt::format("#   {}  {}\n", app.graph.path_name(chain.path), ms_text(chain.response));
        }
        return text;
      }());
}

// By the template's groups, or without one by IDs that are made up.
struct CieGroups {
  std::vector<std::string> ids;  // in order
  std::map<std::string, CieSetting> settings;

  void add_to(const std::string& id, const CieSetting& setting) {
    const auto [at, is_new] = settings.try_emplace(id, setting);
    if (!is_new) {
      add_setting(at->second, setting);
    } else if (std::find(ids.begin(), ids.end(), id) == ids.end()) {
      ids.push_back(id);
    }
  }
};

}  // namespace

Result<CieTemplate> parse_cie_template(const std::string& text, const std::string& file) {
  auto root = config::parse_yaml(text, file, kCiePage);
  if (!root) return root.error();
  config::Problems problems;
  if (config::expect(*root, ValueKind::kMap, "", kTemplateHint, problems)) {
    for (const config::Entry& entry : root->entries) {
      if (entry.key == kCieGroups || entry.key == "non_ros_threads") {
        check_cie_threads(entry.value, entry.key, problems);
      } else if (entry.value.kind == ValueKind::kMap) {
        check_cie_map(entry.value, entry.key, problems);
      }
    }
    if (find_value(*root, kCieGroups) == nullptr)
      problems.add(root->place, kCieGroups, "it is missing", std::string(kTemplateHint));
  }
  if (!problems.empty()) return std::move(problems).to_error();
  return CieTemplate{file, std::move(*root)};
}

Result<CieConfiguration> cie_configuration(const plan::Plan& plan, const graph::App& app,
                                           const std::vector<RosBinding>& bindings, const std::vector<int>& cpus,
                                           const std::optional<CieTemplate>& from) {
  if (priority_above(plan) > kMaxCiePriority) {
    return Error::caller(
        fmt::format("the plan has more than {} priorities on a core, which are all that there are", kMaxCiePriority),
        "give the app more cores, or fewer subchains");
  }
  CieConfiguration made;
  config::Problems problems;
  CieGroups groups;
  const Value* const listed = from ? find_value(from->root, kCieGroups) : nullptr;
  if (listed != nullptr) {
    for (const Value& item : listed->items) groups.ids.push_back(find_value(item, "id")->text);
  }
  const std::vector<bool> overloads = cie_overloads(plan, app, bindings);
  for (const RosBinding& binding : bindings) {
    const std::string& name = app.graph.node(binding.node).name;
    const std::optional<SubchainId> subchain = app.graph.node(binding.node).subchain;
    const bool overloading = subchain && overloads[subchain->index()];
    const CieSetting setting = cie_setting(plan, app, binding.node, cpus, overloading);
    if (std::optional<std::string> said = cie_rate_note(plan, app, binding)) made.notes.push_back(std::move(*said));
    if (overloading) {
      made.notes.push_back(
          fmt::format("{} is called more often than its CPU can run it, so its thread is an ordinary one: "
                      "give what sets it off a lower rate",
                      name));
    }
    if (!from) {
      groups.add_to(cie_id_alone(binding.callback), setting);
      continue;
    }
    std::vector<std::string> having;
    std::copy_if(groups.ids.begin(), groups.ids.end(), std::back_inserter(having),
                 [&](const std::string& id) { return cie_group_has(id, binding.callback); });
    if (having.size() == 1) {
      groups.add_to(having.front(), setting);
      continue;
    }
    problems.add(binding.callback.place, fmt::format("nodes.{}.ros", name),
                 having.empty()
                     ? fmt::format("no callback group of {} has {}", from->file, cie_id_alone(binding.callback))
                     : fmt::format("several callback groups of {} have {}: {}", from->file,
                                   cie_id_alone(binding.callback), fmt::join(having, ", ")),
                 having.empty() ? "write it as the executor's prerun node does, or let that write the file again"
                                : "give timers of one node periods that differ");
  }
  if (!problems.empty()) return std::move(problems).to_error();
  for (const auto& [id, setting] : groups.settings) {
    if (setting.reasons.size() == 1) continue;
    made.notes.push_back(
        fmt::format("{} nodes are callbacks of one group, whose thread has the highest of their "
                    "priorities and all of their CPUs: {}",
                    setting.reasons.size(), id));
  }
  if (!from) {
    made.notes.emplace_back(
        "each callback is taken to be alone in its callback group; --template FILE takes the groups as they are");
  }
  made.text = cie_head_text(plan, app);
  if (from) {
    for (const config::Entry& entry : from->root.entries) {
      if (entry.value.kind == ValueKind::kMap) {
        made.text += fmt::format("{}:\n{}", entry.key, cie_map_text(entry.value, "  ", "  "));
      }
    }
  }
  made.text += fmt::format("{}:\n", kCieGroups);
  for (std::size_t i = 0; i < groups.ids.size(); ++i) {
    const auto setting = groups.settings.find(groups.ids[i]);
    made.text += setting != groups.settings.end() ? cie_setting_text(setting->first, setting->second)
                                                  : cie_map_text(listed->items[i], "  - ", "    ");
  }
  const Value* const threads = from ? find_value(from->root, "non_ros_threads") : nullptr;
  if (threads != nullptr && !threads->items.empty()) {
    made.text += "non_ros_threads:\n";
    for (const Value& item : threads->items) made.text += cie_map_text(item, "  - ", "    ");
  }
  return made;
}

}  // namespace ctn::tool
