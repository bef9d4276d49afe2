// Hidden effects: devices, motions and a truth that the diagnosis
// does not see. Does it name what is there, and only that?
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "experiments/hidden_answer.h"
#include "experiments/hidden_cases.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"

namespace host::experiments {
namespace {

constexpr double most_seconds = 60;  // s per recording of 60 s, one core
constexpr double least_gap_closed = 0.9;

std::string joined(const std::vector<std::string>& names, const char* nothing) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : " + ") + n;
  return text.empty() ? nothing : text;
}

struct Counts {
  int n = 0, exact = 0, in_pair = 0, false_name = 0, in_sigma = 0, cannot = 0, silent = 0, right_beyond = 0;
};

void add(Counts& c, const Judged& j) {
  ++c.n;
  c.exact += j.exact;
  c.in_pair += j.in_pair;
  c.false_name += j.false_name;
  c.in_sigma += j.exact && j.in_three_sigma;
  c.cannot += j.cannot_tell;
  c.silent += j.named.empty();
  const bool open = j.verdict == "unexplained" || j.verdict == "partly_explained";
  c.right_beyond += !j.false_name && (open || (j.unlisted && j.gap_closed >= least_gap_closed));
}

double share(int part, int whole) { return whole ? static_cast<double>(part) / whole : std::nan(""); }

/// How many recordings with this truth got this answer.
Table confusion(const std::vector<std::pair<std::string, Judged>>& all) {
  std::map<std::string, std::map<std::string, int>> counts;
  std::vector<std::string> rows;
  std::set<std::string> answers;
  for (const auto& [row, j] : all) {
    if (!counts.count(row)) rows.push_back(row);
    const std::string said =
        j.judged ? joined(j.named, j.verdict == "consistent" ? "nothing" : j.verdict.c_str()) : "cannot tell";
    ++counts[row][said];
    answers.insert(said);
  }
  Table table{"What is there (rows), what is said (columns)", "Number of recordings.", {{"there", ""}}, {}};
  for (const std::string& a : answers) table.columns.push_back({a, "-"});
  for (const std::string& row : rows) {
    std::vector<Json> line{row};
    for (const std::string& a : answers) line.push_back(counts[row].count(a) ? Json(counts[row][a]) : Json(nullptr));
    table.rows.push_back(line);
  }
  return table;
}

/// Of one scenario: what is visible must be named; what is not may be missing, but nothing false may be said.
void add_scenario_limits(const std::string& scenario, std::map<std::string, Counts>& visible,
                         std::map<std::string, Counts>& all, Findings& out) {
  const auto limit = [&](const char* what, double value, double bound, bool at_least) {
    if (!std::isnan(value)) out.limits.push_back({scenario + ", " + what, value, bound, "-", at_least});
  };
  const auto count = [](const Counts& c, int part) { return c.n ? part : std::nan(""); };
  Counts &none = all["none"], &one = all["one"], &two = all["two"], &outside = all["outside"];
  limit("no effect: share without a name", share(none.silent, none.n), 199.0 / 200, true);
  limit("one visible effect: share named exactly", share(visible["one"].exact, visible["one"].n), 0.95, true);
  limit("one effect: share of those named within 3 sigma", share(one.in_sigma, one.exact), 0.95, true);
  limit("one effect, visible or not: false names", count(one, one.false_name), 0, false);
  limit("two visible effects: share named exactly", share(visible["two"].exact, visible["two"].n), 0.9, true);
  limit("two effects, visible or not: false names", count(two, two.false_name), 0, false);
  limit("outside: false names of the catalogue", count(outside, outside.false_name), 0, false);
  limit("outside: share unexplained, or an unlisted effect that closes the gap", share(outside.right_beyond, outside.n),
        0.95, true);
}

void add_limits(std::map<std::string, Counts>& g, const std::vector<double>& gaps, const std::vector<double>& seconds,
                Findings& out) {
  const auto limit = [&out](const char* what, double value, double bound, const char* unit, bool at_least) {
    if (!std::isnan(value)) out.limits.push_back({what, value, bound, unit, at_least});
  };
  limit("data faults: share named exactly", share(g["fault"].exact, g["fault"].n), 0.95, "-", true);
  limit("weak motion: false names", g["weak"].n ? g["weak"].false_name : std::nan(""), 0, "-", false);
  limit("weak motion: share that says what it cannot tell", share(g["weak"].cannot, g["weak"].n), 1, "-", true);
  if (!gaps.empty()) {
    limit("held-out gap closed, one or two visible effects, named or not: median", quantile(gaps, 0.5), 0.95, "-",
          true);
    limit("held-out gap closed, the same: 10 % quantile", quantile(gaps, 0.1), 0.85, "-", true);
  }
  if (!seconds.empty()) {
    limit("processor time of a recording of 60 s: median", median(seconds), 10, "s", false);
    limit("processor time of a recording of 60 s: largest", *std::max_element(seconds.begin(), seconds.end()),
          most_seconds, "s", false);
  }
}

/// Named exactly against how visible it is.
Figure power_curves(const std::vector<std::pair<std::string, Judged>>& one) {
  Figure figure{"Named exactly, against the score statistic of what is there",
                "lines",
                "log2 of the score statistic, rounded down",
                "share",
                false,
                {}};
  std::map<std::string, std::map<int, std::pair<int, int>>> curves;
  for (const auto& [scenario, j] : one) {
    if (std::isnan(j.statistic)) continue;
    auto& [exact, n] = curves[scenario][static_cast<int>(std::floor(std::log2(std::max(1.0, j.statistic))))];
    exact += j.exact;
    ++n;
  }
  for (const auto& [scenario, curve] : curves) {
    Series line{scenario, {}, {}};
    for (const auto& [octave, counts] : curve) {
      line.x.push_back(octave);
      line.y.push_back(share(counts.first, counts.second));
    }
    figure.series.push_back(line);
  }
  return figure;
}

/// What the cells of all groups add up to.
struct Sums {
  std::map<std::string, Counts> groups;  ///< of all scenarios
  std::map<std::string, std::map<std::string, Counts>> by_scenario, visible;
  std::map<std::pair<std::string, std::string>, Counts> rows;  ///< group and scenario, what is there
  std::vector<std::pair<std::string, std::string>> order;
  std::vector<std::pair<std::string, Judged>> said, one;  ///< what is there; scenario
  std::vector<double> gaps, seconds;

  void take(const Json& parameters, const Judged& j) {
    const std::string group = parameters.at("group"), scenario = parameters.at("scenario"),
                      there = joined(j.truth, "nothing");
    const std::pair<std::string, std::string> row = {group + ", " + scenario, there};
    if (!rows.count(row)) order.push_back(row);
    add(rows[row], j);
    add(groups[group], j);
    add(by_scenario[scenario][group], j);
    if (j.visible) add(visible[scenario][group], j);
    said.emplace_back(scenario + ": " + there, j);
    if (group == "one") one.emplace_back(scenario, j);
    if ((group == "one" || group == "two") && j.visible && !std::isnan(j.gap_closed)) gaps.push_back(j.gap_closed);
    seconds.push_back(j.seconds);
  }
};

}  // namespace

std::vector<Cell> hidden_cells(const StudyOptions& options) { return hidden_cases(options); }

Json hidden_run(const Json& parameters) {
  const SimulationResult session = hidden_session(parameters);
  return {{"truth", hidden_truth(session.effects)}, {"answer", diagnosed(session.recording, session.nominal)}};
}

Findings hidden_gather(const std::vector<CellResult>& cells) {
  Table table{"Hidden effects",
              "named exactly: what is there and nothing else. As a pair: the same, but with another effect that the "
              "motion does not tell from it. Sigmas count recordings named exactly.",
              {{"group", ""},
               {"there", ""},
               {"recordings", "-"},
               {"named exactly", "-"},
               {"as a pair", "-"},
               {"false name", "-"},
               {"within 3 sigma", "-"},
               {"nothing named", "-"},
               {"cannot tell", "-"}},
              {}};
  Table missed{"Not named exactly",
               "Statistic: of what is there, at the fit without effects; below 60 it counts as not visible.",
               {{"scenario", ""},
                {"there", ""},
                {"lens", ""},
                {"tracks", ""},
                {"images", "1/s"},
                {"statistic", "-"},
                {"said", ""},
                {"verdict", ""},
                {"gap closed", "-"},
                {"seed", "-"}},
               {}};
  Sums sums;
  for (const CellResult& cell : cells) {
    const Json& p = cell.parameters;
    const Judged j = judged(cell);
    sums.take(p, j);
    if (j.exact || p.at("group") == "outside") continue;
    std::string effects;
    for (const Json& e : p.at("effects")) effects += (effects.empty() ? "" : " + ") + e.get<std::string>();
    missed.rows.push_back({p.at("scenario"), effects.empty() ? "nothing" : effects, p.at("distortion"), p.at("tracks"),
                           p.at("images_per_s"), j.statistic, joined(j.named, "nothing"), j.verdict, j.gap_closed,
                           p.at("seed")});
  }
  std::sort(sums.order.begin(), sums.order.end());
  for (const auto& key : sums.order) {
    const Counts& c = sums.rows[key];
    table.rows.push_back(
        {key.first, key.second, c.n, c.exact, c.in_pair, c.false_name, c.in_sigma, c.silent, c.cannot});
  }
  Findings out;
  out.tables = {table, confusion(sums.said), missed};
  out.figures = {power_curves(sums.one)};
  for (auto& [scenario, groups] : sums.by_scenario) add_scenario_limits(scenario, sums.visible[scenario], groups, out);
  add_limits(sums.groups, sums.gaps, sums.seconds, out);
  return out;
}

}  // namespace host::experiments
