#include "page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "os/linux/whole_file.h"
#include "page/assets.h"
#include "page/comparison.h"
#include "page/data.h"
#include "page/graph_picture.h"
#include "page/late.h"
#include "page/plots.h"
#include "report/escape.h"
#include "report/html.h"
#include "report/text.h"

namespace ctn::page {
namespace {

using report::escaped;

// Percent of the page's size that detail is given at first; where the page becomes too large, half of it, and so on.
constexpr std::size_t kFirstShare = 60;

const std::array<const char*, 2> kRunColours{"var(--accent)", "#d55e00"};

// As colourOf() of src/palette.js.
std::string colour(std::size_t index) {
  if (index < palette().size()) return palette()[index];
  return fmt::format("hsl({} 45% 55%)", index * 137 % 360);
}

using ShownRuns = std::span<const ShownRun>;

// By lane of each run; lanes of the same name get the same colour.
std::vector<std::vector<std::string>> lane_colours(ShownRuns runs) {
  std::vector<std::string> names;
  std::vector<std::vector<std::string>> colours;
  for (const ShownRun& run : runs) {
    auto& of_run = colours.emplace_back();
    for (const Lane& lane : run.story.lanes) {
      auto found = std::find(names.begin(), names.end(), lane.name);
      if (found == names.end()) found = names.insert(found, lane.name);
      of_run.push_back(colour(static_cast<std::size_t>(found - names.begin())));
    }
  }
  return colours;
}

std::string seconds(Micros duration) { return fmt::format("{:.4g} s", static_cast<double>(duration) / 1e6); }

class Writer {
 public:
  Writer(ShownRuns runs, std::vector<std::string> differences)
      : runs_(runs), differences_(std::move(differences)), colours_(lane_colours(runs)) {}

  Glance glance() const {
    const ShownRun& run = runs_.front();
    return {fmt::format("<style>{}</style>", kStyle), graph_box(run) + "<figure class=\"chart\">" +
                                                          cores_picture(run.story, colours_.front()) + "</figure>" +
                                                          legend(run)};
  }

  std::string write(std::size_t max_bytes) const {
    const std::string before = head_and_pictures();
    std::size_t detail = max_bytes / 100 * kFirstShare / runs_.size();
    while (true) {
      std::string html = with_data(before, detail);
      if (html.size() <= max_bytes || detail == 0) return html;
      detail = detail < 1000 ? 0 : detail / 2;
    }
  }

 private:
  static constexpr std::size_t kNoChain = static_cast<std::size_t>(-1);
  // Where the data and what is said of them go.
  static constexpr const char* kDataPlace = "<!--data-->";
  static constexpr const char* kOmittedPlace = "<!--omitted-->";

  const Story& first() const { return runs_.front().story; }
  bool compares() const { return runs_.size() > 1; }

  std::string head_and_pictures() const {
    report::Page page(compares() ? fmt::format("{}: {} and {}", first().figures.app, runs_[0].name, runs_[1].name)
                                 : "Run of " + first().figures.app,
                      compares() ? "" : report::headline(first().figures));
    page.head(
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
        "script-src 'unsafe-inline'\">");
    page.head(fmt::format("<style>{}</style>", kStyle));
    page.element(
        "<nav aria-label=\"Parts of the page\"><a href=\"#app\">App</a><a href=\"#cores\">Cores</a><a "
        "href=\"#responses\">Response times</a><a href=\"#compute\">Compute times</a><a "
        "href=\"#figures\">Figures</a><a "
        "href=\"#events\">Events</a></nav>");
    what_ran(page);
    app(page);
    cores(page);
    responses(page);
    compute(page);
    figures(page);
    events(page);
    page.element(kDataPlace);
    return page.html();
  }

  void what_ran(report::Page& page) const {
    for (const ShownRun& run : runs_) {
      const report::RunFigures& figures = run.story.figures;
      const record::Header& header = figures.header;
      if (compares()) {
        page.element(fmt::format("<h3 class=\"run\"><span class=\"swatch\" style=\"background:{}\"></span>{}</h3>",
                                 kRunColours[run_index(run)], escaped(run.name)));
        page.paragraph(report::headline(figures));
      }
      std::string started = header.host.utc;
      std::replace(started.begin(), started.end(), 'T', ' ');  // so that the line may break there
      std::vector<std::pair<std::string, std::string>> facts{
          {"Started", started},
          {"Ran for", seconds(run.story.duration) + (figures.ending.closed ? ", complete" : ", not complete")},
          {"Scheduler", header.scheduler},
          {"CPUs", header.cpus.empty() ? "unknown" : os::to_string(header.cpus)},
          {"Real-time levels", header.real_time ? "yes" : "no"},
          {"Processor", header.host.cpu_model},
          {"Plans in force", std::to_string(run.story.plans.size())},
          {"Kernel", header.host.kernel}};
      facts.erase(std::remove_if(facts.begin(), facts.end(), [](const auto& fact) { return fact.second.empty(); }),
                  facts.end());
      page.facts(facts);
      if (!header.note.empty()) page.note(header.note);
      for (const std::string& warning : report::warnings(figures)) page.note(warning, report::NoteKind::kWarning);
    }
    for (const std::string& difference : differences_) page.note(difference);
  }

  std::size_t run_index(const ShownRun& run) const { return static_cast<std::size_t>(&run - runs_.data()); }
  std::string of_run(const ShownRun& run) const { return compares() ? ", " + run.name : ""; }

  void app(report::Page& page) const {
    page.section("The app", "app");
    for (const ShownRun& run : runs_) {
      if (run_index(run) > 0 && differences_.empty()) break;  // both have the same graph
      page.element(graph_box(run));
      page.element("<p class=\"caption\">Mean compute time and rate of each node" + escaped(of_run(run)) +
                   ". Boxes around nodes are subchains: each node triggers the next. Dashed: unscheduled; dotted: "
                   "external.</p>");
    }
  }

  std::string graph_box(const ShownRun& run) const {
    const Story& story = run.story;
    const auto nodes = story.app.graph.nodes();
    std::vector<std::string> notes(nodes.size());
    std::vector<std::string> node_colours(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (story.lane_of[i] != kNoLane) node_colours[i] = colours_[run_index(run)][story.lane_of[i]];
      for (const report::NodeMetrics& node : story.figures.nodes) {
        if (node.name == nodes[i].name && node.runs > 0) {
          notes[i] = fmt::format("{:.3g} ms, {:.3g} Hz", node.compute_ms.mean, node.rate_hz);
        }
      }
    }
    return "<div class=\"scroll graph-box\" tabindex=\"0\" role=\"group\" aria-label=\"The app's graph\">" +
           graph_picture(story.app.graph, notes, node_colours) + "</div>";
  }

  void cores(report::Page& page) const {
    page.section("Cores", "cores");
    page.element(
        "<div class=\"toolbar live-only\" role=\"toolbar\" aria-label=\"Time that is shown\">"
        "<button type=\"button\" data-do=\"in\" aria-label=\"Zoom in\" title=\"Zoom in (+)\">+</button>"
        "<button type=\"button\" data-do=\"out\" aria-label=\"Zoom out\" title=\"Zoom out (-)\">−</button>"
        "<button type=\"button\" data-do=\"left\" aria-label=\"Earlier\" title=\"Earlier (left arrow)\">◀</button>"
        "<button type=\"button\" data-do=\"right\" aria-label=\"Later\" title=\"Later (right arrow)\">▶</button>"
        "<button type=\"button\" data-do=\"all\" title=\"The whole run (Home)\">All</button>"
        "<select id=\"goto\" aria-label=\"Go to\"></select><span id=\"range\" aria-live=\"polite\"></span></div>");
    for (const ShownRun& run : runs_) {
      if (compares()) page.element(fmt::format("<h3>{}</h3>", escaped(run.name)));
      page.element(fmt::format(
          "<figure class=\"chart\"><div class=\"panel\" data-kind=\"cores\" data-run=\"{}\" data-label=\"{}\"></div>"
          "<div class=\"static\">{}</div></figure>",
          run_index(run), escaped("Timeline of cores" + of_run(run)),
          cores_picture(run.story, colours_[run_index(run)])));
      page.element(legend(run));
      busy_summary(page, run);
    }
    page.element(kOmittedPlace);
    page.element(
        "<details class=\"live-only help\"><summary>How to read and move it</summary><p>A core's upper row shows "
        "what had it; below are each subchain's runs from begin to end, pale where another had the core. The record "
        "does not say when that was: under frames and fixed priorities it is found from the slots and runs of others. "
        "Small ticks at the foot of a row are triggers, red if sent over 1 ms late; triangles are overruns; hatched "
        "pieces are stolen from another subchain's slot. Dashed lines are changes of plan, diamonds notices, circles "
        "lasting changes of compute time, squares changes of weights and bounds. Zoomed out, areas are busy "
        "shares.</p><p>Drag to move, wheel or pinch to zoom; all charts show the same time. With the keyboard, in a "
        "chart: arrows move, + and - zoom, Home shows everything, n and p go to the next and the previous "
        "event.</p></details>");
  }

  // Adds nothing if there are too many lanes: rows have labels anyway.
  std::string legend(const ShownRun& run) const {
    if (run.story.lanes.size() > 40) return {};
    std::string text = "<p class=\"legend\">";
    for (std::size_t i = 0; i < run.story.lanes.size(); ++i) {
      text += fmt::format("<span><span class=\"swatch\" style=\"background:{}\"></span>{}</span> ",
                          colours_[run_index(run)][i], escaped(run.story.lanes[i].name));
    }
    return text + "</p>";
  }

  // The timeline in words, for readers who cannot see it.
  static void busy_summary(report::Page& page, const ShownRun& run) {
    std::vector<double> busy(run.story.lanes.size());
    for (const RunSpan& one : run.story.runs) busy[run.story.lane_of[one.node]] += static_cast<double>(one.cpu_ms);
    std::string text = "CPU time of the whole run, in cores:";
    for (std::size_t i = 0; i < std::min<std::size_t>(busy.size(), 12); ++i) {
      text += fmt::format(" {} {:.3f}{}", run.story.lanes[i].name,
                          1e3 * busy[i] / static_cast<double>(run.story.duration), i + 1 < busy.size() ? "," : ".");
    }
    if (busy.size() > 12) text += fmt::format(" and {} more.", busy.size() - 12);
    const PlanSpan* const plan = plan_at(run.story, run.story.duration);
    if (plan != nullptr) {
      text += " In the last plan:";
      for (std::size_t i = 0; i < plan->placements.size() && i < 12; ++i) {
        const Placement& one = plan->placements[i];
        text += fmt::format("{} {} on core {}{}", i > 0 ? "," : "", run.story.lanes[one.lane].name, one.core,
                            one.priority > 0 ? fmt::format(" at priority {}", one.priority) : "");
      }
      text += ".";
    }
    page.element("<p class=\"caption\">" + escaped(text) + "</p>");
  }

  static std::vector<double> measured_ms(const Story& story, std::size_t chain) {
    std::vector<double> samples;
    for (const ResponsePoint& response : story.responses[chain]) {
      if (response.end - static_cast<Micros>(1e3 * response.response_ms) >= story.measured_from) {
        samples.push_back(response.response_ms);
      }
    }
    return samples;
  }

  void responses(report::Page& page) const {
    page.section("Response times", "responses");
    page.element(
        "<p class=\"caption\">Left, over time, in ms: mean, 95th percentile (the area's upper edge) and maximum; "
        "single responses where there is room. Right, by rank, after the warm-up: which part of all is at most that "
        "long. Promised: the worst case as planned. Expected: the mean as planned. Below: the longest responses, as "
        "bars of what they consist of, with the one cause if late; open one for its parts.</p>");
    const Story& story = first();
    for (std::size_t i = 0; i < story.responses.size(); ++i) {
      const report::ChainMetrics& metrics = story.figures.chains[i];
      std::vector<Curve> curves{{runs_[0].name, kRunColours[0], measured_ms(story, i)}};
      std::string names = fmt::format("data-chain=\"{}\"", i);
      const std::size_t other = compares() ? common_chain(i) : kNoChain;
      if (other != kNoChain) {
        curves.push_back({runs_[1].name, kRunColours[1], measured_ms(runs_[1].story, other), true});
        names += fmt::format(" data-other=\"{}\"", other);
      }
      std::vector<PlotLevel> levels;
      if (metrics.bound_ms) levels.push_back({"bound", *metrics.bound_ms});
      if (metrics.predicted) {
        levels.push_back({"promised", metrics.predicted->promised_response_ms});
        levels.push_back({"expected", metrics.predicted->response_ms});
      }
      std::string line = chain_line(metrics);
      if (other != kNoChain) line += in_other(chain_line(runs_[1].story.figures.chains[other]));
      page.element(card(metrics.path, line, "response", names, "Response times of " + metrics.path,
                        responses_picture(story, i),
                        percentile_picture("Distribution of the response times of " + metrics.path, curves, levels)));
      late(page, runs_[0], i);
      if (other != kNoChain) late(page, runs_[1], other);
      page.element("</div>");
    }
    if (story.responses.empty()) page.paragraph("The objective has no response times.");
  }

  void late(report::Page& page, const ShownRun& run, std::size_t chain) const {
    if (compares()) page.element("<h4>" + escaped("Longest in " + run.name) + "</h4>");
    add_late(page, run.story, chain);
  }

  std::size_t common_chain(std::size_t chain) const {
    return find_chain(runs_[1].story.figures, first().figures.chains[chain].path).value_or(kNoChain);
  }

  static std::string chain_line(const report::ChainMetrics& chain) {
    if (chain.response_ms.count == 0) return "none measured";
    std::string text = fmt::format("mean {:.4g} ms, p95 {:.4g}, max {:.4g}", chain.response_ms.mean,
                                   chain.response_ms.p95, chain.response_ms.max);
    if (chain.predicted)
      text += fmt::format("; expected {:.4g}, promised {:.4g}", chain.predicted->response_ms,
                          chain.predicted->promised_response_ms);
    if (chain.bound_ms) text += fmt::format("; bound {:.4g}", *chain.bound_ms);
    return text;
  }

  std::string in_other(const std::string& line) const {
    return line.empty() ? "" : fmt::format(". In {}: {}", runs_[1].name, line);
  }

  static std::string node_line(const report::RunFigures& figures, const std::string& name) {
    for (const report::NodeMetrics& node : figures.nodes) {
      if (node.name != name) continue;
      if (node.runs == 0) return "no runs";
      return fmt::format("mean {:.4g} ms, p95 {:.4g}, max {:.4g}; {:.4g} Hz", node.compute_ms.mean, node.compute_ms.p95,
                         node.compute_ms.max, node.rate_hz);
    }
    return {};
  }

  // Without its end.
  static std::string card(const std::string& title, const std::string& line, const std::string& kind,
                          const std::string& data, const std::string& label, const std::string& still,
                          const std::string& distribution) {
    return fmt::format(
        "<div class=\"card\"><div class=\"card-head\"><h3>{}</h3><p>{}</p></div><div class=\"card-body\"><div "
        "class=\"over-time\"><div class=\"panel\" data-kind=\"{}\" {} data-label=\"{}\"></div><div "
        "class=\"static\">{}</div></div><div class=\"by-rank\">{}</div></div>",
        escaped(title), escaped(line), kind, data, escaped(label), still, distribution);
  }

  void compute(report::Page& page) const {
    page.section("Compute times", "compute");
    page.element(
        "<p class=\"caption\">CPU time of a run in ms, by mode; over time mean and maximum, the area up to "
        "the 95th percentile. Circles mark lasting changes.</p>");
    std::vector<std::vector<ModeSamples>> samples;  // by run
    for (const ShownRun& run : runs_) samples.push_back(compute_samples_ms(run.story));
    const auto nodes = first().app.graph.nodes();
    std::size_t count = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (first().lane_of[i] == kNoLane) continue;
      if (++count == 25) page.element("<details><summary>More nodes</summary>");
      page.element(node_card(i, samples));
    }
    if (count >= 25) page.element("</details>");
  }

  std::string node_card(std::size_t i, const std::vector<std::vector<ModeSamples>>& samples) const {
    const graph::Node& node = first().app.graph.nodes()[i];
    std::vector<Curve> curves;
    const auto add = [&](std::size_t run, std::size_t index) {
      const ModeSamples& modes = samples[run][index];
      for (std::size_t mode = 0; mode < modes.size(); ++mode) {
        const bool by_mode = modes.size() > 1 && !compares();
        curves.push_back({"", by_mode ? colour(mode) : kRunColours[run], modes[mode], run > 0});
      }
    };
    add(0, i);
    std::string names = fmt::format("data-node=\"{}\"", i);
    if (compares()) {
      if (const auto other = runs_[1].story.app.graph.find_node(node.name)) {
        if (runs_[1].story.lane_of[other->index()] != kNoLane) {
          add(1, other->index());
          names += fmt::format(" data-other=\"{}\"", other->index());
        }
      }
    }
    std::string line = node_line(first().figures, node.name);
    if (compares()) line += in_other(node_line(runs_[1].story.figures, node.name));
    if (node.modes.size() > 1 && !compares()) {
      for (std::size_t mode = 0; mode < node.modes.size(); ++mode) {
        line += fmt::format("{} {}: {} runs", mode == 0 ? ";" : ",", node.modes[mode], samples[0][i][mode].size());
      }
    }
    return card(node.name, line, "compute", names, "Compute times of " + node.name, "",
                percentile_picture("Distribution of the compute times of " + node.name, curves, {})) +
           "</div>";
  }

  void figures(report::Page& page) const {
    page.section(compares() ? "Figures, side by side" : "Figures: predicted beside measured", "figures");
    if (compares()) {
      page.paragraph(
          fmt::format("a is {}, b is {}; in brackets, by how much b differs from a.", runs_[0].name, runs_[1].name));
      for (const report::Table& table :
           comparison_tables(first().figures, runs_[0].name, runs_[1].story.figures, runs_[1].name)) {
        page.table(table);
      }
    }
    for (const ShownRun& run : runs_) {
      if (compares()) page.element("<h3>" + escaped(run.name) + "</h3>");
      for (const report::Table& table : report::tables(run.story.figures)) page.table(table);
    }
  }

  void events(report::Page& page) const {
    constexpr std::size_t kMaxRows = 200;
    page.section("Events", "events");
    for (const ShownRun& run : runs_) {
      report::Table table{.header = {"s", "kind", "what"}, .caption = "Plans, changes and notices" + of_run(run)};
      for (const Event& event : run.story.events) {
        if (table.rows.size() == kMaxRows) break;
        table.rows.push_back({fmt::format("{:.3f}", static_cast<double>(event.at) / 1e6), to_string(event.kind),
                              event.text.substr(0, 400)});
      }
      if (run.story.events.size() > kMaxRows) {
        table.caption += fmt::format(": the first {} of {}", kMaxRows, run.story.events.size());
      }
      if (table.rows.empty()) {
        page.paragraph("There were no events other than runs" + of_run(run) + ".");
      } else {
        page.table(table);
      }
    }
  }

  std::string with_data(std::string html, std::size_t budget) const {
    std::string data;
    std::string omitted;
    for (const ShownRun& run : runs_) {
      const Detail detail = choose_detail(run.story, budget);
      data += (data.empty() ? "" : ",\n") + data_of(run.story, run.name, detail, colours_[run_index(run)]);
      if (detail.whole()) continue;
      omitted += fmt::format(
          "<div class=\"note\">{}</div>",
          escaped(fmt::format("In full detail{}: {} of {}, which are the worst responses of each chain, the beginning, "
                              "and what surrounds changes of plan and other events, then as much as the page has room "
                              "for. Elsewhere the timelines show busy shares; figures are of all runs.",
                              of_run(run), seconds(detail.covered()), seconds(run.story.duration))));
    }
    const auto put = [&](const std::string& place, const std::string& text) {
      html.replace(html.rfind(place), place.size(), text);
    };
    put(kDataPlace,
        fmt::format("<script type=\"application/json\" id=\"catan-data\">[{}]</script>\n<script>{}</script>", data,
                    kScript));
    put(kOmittedPlace, omitted);
    return html;
  }

  ShownRuns runs_;
  std::vector<std::string> differences_;
  std::vector<std::vector<std::string>> colours_;  // by run, by lane
};

}  // namespace

std::string to_html(const ShownRun& run, std::size_t max_bytes) { return Writer({&run, 1}, {}).write(max_bytes); }

Glance glance(const ShownRun& run) { return Writer({&run, 1}, {}).glance(); }

Result<std::string> compare_html(const ShownRun& run, const ShownRun& other, std::size_t max_bytes) {
  auto differences = differences_of(run.story.app, run.name, other.story.app, other.name);
  if (!differences) return differences.error();
  const std::array<ShownRun, 2> runs{run, other};
  return Writer(runs, std::move(*differences)).write(max_bytes);
}

Status save(const std::string& html, const std::string& file) {
  if (record::looks_like_record(file)) {
    return Error::caller(quote(file) + " is a record, which a page would replace", "name another file after --html");
  }
  return os::replace_file(file, html);
}

}  // namespace ctn::page
