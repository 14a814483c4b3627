#include "contest_apps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/mixed.h"
#include "config/app_file.h"
#include "config/cost_file.h"
#include "model/portable_math.h"

namespace ctn::bench {
namespace {

constexpr double kCheapest = 0.3;  // ms, of a node
constexpr double kMostExpensive = 150.0;
constexpr double kAlike = 3.0;  // nodes of a subchain cost so many times more or less than its middle, at most
constexpr double kLightest = 0.005;
constexpr double kHeaviest = 1.0;
constexpr double kByHand = 0.7;  // of one core, that rates set by hand share out

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : seed_(seed) {}

  double uniform(double low, double high) { return low + (high - low) * fraction_of(mixed_of(seed_, ++drawn_)); }
  double log_uniform(double low, double high) {
    return low * model::portable_exp(uniform(0.0, 1.0) * model::portable_log(high / low));
  }
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
  std::size_t below(std::size_t limit) { return mixed_of(seed_, ++drawn_) % limit; }

 private:
  std::uint64_t seed_;
  std::uint64_t drawn_ = 0;
};

// As it is written, so that what is computed from it is of what is written.
double written(double value) { return std::stod(fmt::format("{:.3g}", value)); }

struct Node {
  std::string name;
  double cost = 0.0;  // ms
  std::optional<double> typical;
  double spike_probability = 0.0;
  double spike = 0.0;
};

struct Subchain {
  std::string name;
  std::vector<Node> nodes;
  double weight = 0.0;  // of all terms that it takes part in

  double cost() const {
    double sum = 0.0;
    for (const Node& node : nodes) sum += node.cost;
    return sum;
  }
};

// The way of a chain through a subchain: from its node `enters` to its tail.
struct Stretch {
  std::size_t subchain = 0;
  std::size_t enters = 0;
  friend auto operator<=>(const Stretch&, const Stretch&) = default;
};
using Chain = std::vector<Stretch>;

struct Term {
  std::optional<Chain> chain;  // a response time
  std::size_t period_of = 0;   // else a subchain's period
  double weight = 0.0;
};

Node random_node(Draws& draws, std::string name, double middle) {
  Node node;
  node.name = std::move(name);
  node.cost =
      written(draws.log_uniform(std::max(kCheapest, middle / kAlike), std::min(kMostExpensive, middle * kAlike)));
  if (draws.chance(0.8)) node.typical = written(node.cost * draws.log_uniform(0.4, 0.9));
  if (draws.chance(0.3)) {
    node.spike_probability = written(draws.log_uniform(0.003, 0.03));
    node.spike = written(std::min(kMostExpensive, node.cost * draws.log_uniform(0.5, 4.0)));
  }
  return node;
}

std::vector<Subchain> random_subchains(Draws& draws) {
  std::vector<Subchain> subchains(2 + draws.below(11));
  for (std::size_t i = 0; i < subchains.size(); ++i) {
    subchains[i].name = fmt::format("s{}", i + 1);
    const std::size_t nodes = 1 + draws.below(3);
    const double middle = draws.log_uniform(kCheapest, kMostExpensive);
    for (std::size_t k = 0; k < nodes; ++k) {
      subchains[i].nodes.push_back(
          random_node(draws, fmt::format("{}{}", subchains[i].name, static_cast<char>('a' + k)), middle));
    }
  }
  return subchains;
}

// Each subchain has one chain of its own, and is in each other by chance. Data flows from lower to higher numbers, so
// there are no cycles. No two are the same.
std::vector<Chain> random_chains(Draws& draws, const std::vector<Subchain>& subchains) {
  std::vector<Chain> chains(2 + draws.below(4));
  for (std::size_t i = 0; i < subchains.size(); ++i) {
    const std::size_t own = draws.below(chains.size());
    for (std::size_t c = 0; c < chains.size(); ++c) {
      if (c != own && !draws.chance(0.25)) continue;
      const bool later = !chains[c].empty() && draws.chance(0.3);
      chains[c].push_back({i, later ? draws.below(subchains[i].nodes.size()) : 0});
    }
  }
  std::set<Chain> known{Chain{}};
  std::erase_if(chains, [&](const Chain& chain) { return !known.insert(chain).second; });
  // One that is left alone goes through all subchains.
  if (chains.size() == 1) chains.push_back({{subchains.size() - 1, 0}});
  return chains;
}

std::vector<Term> random_terms(Draws& draws, std::vector<Subchain>& subchains) {
  std::vector<Term> terms;
  for (Chain& chain : random_chains(draws, subchains)) {
    terms.push_back({std::move(chain), 0, written(draws.log_uniform(kLightest, kHeaviest))});
    for (const Stretch& stretch : *terms.back().chain) subchains[stretch.subchain].weight += terms.back().weight;
  }
  if (draws.chance(0.5)) {
    terms.push_back({{}, draws.below(subchains.size()), written(draws.log_uniform(kLightest, kHeaviest))});
    subchains[terms.back().period_of].weight += terms.back().weight;
  }
  return terms;
}

// Rounded down, as people write rates.
double plain_rate(double hertz) {
  constexpr std::array<double, 10> kSteps{1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0};
  double decade = 1.0;
  while (hertz < decade) decade /= 10.0;
  while (hertz >= 10.0 * decade) decade *= 10.0;
  double rate = decade;
  for (const double step : kSteps) {
    if (step * decade <= hertz) rate = step * decade;
  }
  return rate;
}

std::vector<double> rates_by_hand(const std::vector<Subchain>& subchains) {
  double sum = 0.0;
  for (const Subchain& subchain : subchains) sum += std::sqrt(subchain.weight * subchain.cost());
  std::vector<double> rates;
  for (const Subchain& subchain : subchains) {
    const double share = kByHand * std::sqrt(subchain.weight * subchain.cost()) / sum;
    rates.push_back(plain_rate(1000.0 * share / subchain.cost()));
  }
  return rates;
}

std::vector<std::string> path_of(const Chain& chain, const std::vector<Subchain>& subchains) {
  std::vector<std::string> path;
  for (const Stretch& stretch : chain) {
    const std::vector<Node>& nodes = subchains[stretch.subchain].nodes;
    for (std::size_t k = stretch.enters; k < nodes.size(); ++k) path.push_back(nodes[k].name);
  }
  return path;
}

// Each once, in the order in which subchains and chains have them.
std::string edges_text(const std::vector<Subchain>& subchains, const std::vector<Term>& terms) {
  std::string text;
  std::set<std::pair<std::string, std::string>> known;
  const auto add = [&](const std::vector<std::string>& path) {
    for (std::size_t i = 1; i < path.size(); ++i) {
      if (known.insert({path[i - 1], path[i]}).second) text += fmt::format("  - {} -> {}\n", path[i - 1], path[i]);
    }
  };
  for (std::size_t i = 0; i < subchains.size(); ++i) add(path_of({{i, 0}}, subchains));
  for (const Term& term : terms) {
    if (term.chain) add(path_of(*term.chain, subchains));
  }
  return text.empty() ? text : "edges:\n" + text;
}

std::string app_text(const std::string& name, const std::vector<Subchain>& subchains, const std::vector<Term>& terms) {
  const std::vector<double> rates = rates_by_hand(subchains);
  std::string nodes = "nodes:\n";
  std::string named = "subchains:\n";
  for (std::size_t i = 0; i < subchains.size(); ++i) {
    std::vector<std::string> row;
    for (const Node& node : subchains[i].nodes) {
      row.push_back(node.name);
      nodes += row.size() > 1 ? fmt::format("  {}: {{}}\n", node.name)
                              : fmt::format("  {}: {{ fallback_rate: {:g}Hz }}\n", node.name, rates[i]);
    }
    named += fmt::format("  {}: [{}]\n", subchains[i].name, fmt::join(row, ", "));
  }
  std::string objective = "objective:\n";
  for (const Term& term : terms) {
    if (term.chain) {
      objective += fmt::format("  - {{ response_time: [{}], weight: {:g} }}\n",
                               fmt::join(path_of(*term.chain, subchains), ", "), term.weight);
    } else {
      objective += fmt::format("  - {{ period: {}, weight: {:g} }}\n", subchains[term.period_of].nodes.front().name,
                               term.weight);
    }
  }
  return fmt::format("catan: 1\napp: {}\n{}{}{}{}", name, nodes, edges_text(subchains, terms), named, objective);
}

std::string load_of(const Node& node) {
  std::string text = fmt::format("{}: {{ cost: {:g}ms", node.name, node.cost);
  if (node.typical) text += fmt::format(", typical: {:g}ms", *node.typical);
  if (node.spike > 0.0) text += fmt::format(", spikes: [{:g}, {:g}ms]", node.spike_probability, node.spike);
  return text + " }\n";
}

}  // namespace

AppFiles random_app(std::uint64_t seed) {
  Draws draws(seed);
  std::vector<Subchain> subchains = random_subchains(draws);
  const std::vector<Term> terms = random_terms(draws, subchains);
  AppFiles files;
  files.name = fmt::format("random_{}", seed);
  files.app = app_text(files.name, subchains, terms);
  for (const Subchain& subchain : subchains) {
    for (const Node& node : subchain.nodes) {
      files.costs += fmt::format("{}: {:g}ms\n", node.name, node.cost);
      files.load += load_of(node);
    }
  }
  return files;
}

Case case_of(const AppFiles& files) {
  Result<graph::App> app = config::parse_app(files.app, files.name + ".yaml");
  if (!app) throw std::runtime_error(app.error().message());
  Result<model::Workload> work = config::parse_workload(files.load, files.name + ".load.yaml", *app);
  if (!work) throw std::runtime_error(work.error().message());
  return {files.name, std::move(*app), std::move(*work)};
}

}  // namespace ctn::bench
