// Hidden effects: devices, motions and a truth that the diagnosis does not see. Does it name what is there, and only that?
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

constexpr double most_seconds = 60;      // s per recording of 60 s, one core
constexpr double least_gap_closed = 0.9;

std::string joined(const std::vector<std::string>& names, const char* nothing) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : " + ") + n;
  return text.empty() ? nothing : text;
}

struct Counts {
  int n = 0, exact = 0, in_pair = 0, false_name = 0, in_sigma = 0, closed = 0, cannot = 0, silent = 0, right_beyond = 0;
};

void add(Counts& c, const Judged& j) {
  ++c.n;
  c.exact += j.exact;
  c.in_pair += j.in_pair;
  c.false_name += j.false_name;
  c.in_sigma += j.exact && j.in_three_sigma;
  c.closed += j.exact && j.gap_closed >= least_gap_closed;
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
    const std::string said = j.judged ? joined(j.named, j.verdict == "consistent" ? "nothing" : j.verdict.c_str()) : "cannot tell";
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

void add_limits(std::map<std::string, Counts>& g, double slowest, Findings& out) {
  const auto limit = [&out](const char* what, double value, double bound, bool at_least) {
    if (!std::isnan(value)) out.limits.push_back({what, value, bound, "-", at_least});
  };
  limit("no effect: share without a name", share(g["none"].silent, g["none"].n), 39.0 / 40, true);
  limit("one effect: share named exactly", share(g["one"].exact, g["one"].n), 0.95, true);
  limit("one effect: share of these within 3 sigma", share(g["one"].in_sigma, g["one"].exact), 0.95, true);
  limit("one effect: share of these with 90 % of the held-out gap closed", share(g["one"].closed, g["one"].exact), 0.95, true);
  limit("data faults: share named exactly", share(g["fault"].exact, g["fault"].n), 0.95, true);
  limit("two effects: share named exactly", share(g["two"].exact, g["two"].n), 0.85, true);
  limit("outside: recordings with a false name of the catalogue", g["outside"].n ? g["outside"].false_name : std::nan(""), 0, false);
  limit("outside: share unexplained, or an unlisted effect that closes the gap",
        share(g["outside"].right_beyond, g["outside"].n), 1, true);
  limit("weak motion: recordings with a false name", g["weak"].n ? g["weak"].false_name : std::nan(""), 0, false);
  limit("weak motion: share that says what it cannot tell", share(g["weak"].cannot, g["weak"].n), 1, true);
  out.limits.push_back({"slowest recording of 60 s, processor time", slowest, most_seconds, "s", false});
}

}  // namespace

std::vector<Cell> hidden_cells(const StudyOptions& options) { return hidden_cases(options); }

Json hidden_run(const Json& parameters) {
  const SimulationResult session = hidden_session(parameters);
  return {{"truth", hidden_truth(session.effects)}, {"answer", diagnosed(session.recording, session.nominal)}};
}

Findings hidden_gather(const std::vector<CellResult>& cells) {
  Table table{"Hidden effects", "named exactly: what is there and nothing else. As a pair: the same, but with another effect that the motion does not tell "
              "from it. Sigmas and gaps count recordings named exactly.",
              {{"group", ""}, {"there", ""}, {"recordings", "-"}, {"named exactly", "-"}, {"as a pair", "-"}, {"false name", "-"},
               {"within 3 sigma", "-"}, {"gap closed by 90 %", "-"}, {"nothing named", "-"}, {"cannot tell", "-"}}, {}};
  Table missed{"Not named exactly", "", {{"there", ""}, {"said", ""}, {"verdict", ""}, {"gap closed", "-"}, {"seed", "-"}}, {}};
  std::map<std::string, Counts> groups;
  std::map<std::pair<std::string, std::string>, Counts> rows;
  std::vector<std::pair<std::string, std::string>> order;
  std::vector<std::pair<std::string, Judged>> all;
  double slowest = 0;
  for (const CellResult& cell : cells) {
    const Judged j = judged(cell);
    const std::string group = cell.parameters.at("group");
    const std::string there = group_of(group) == HiddenGroup::weak ? cell.parameters.at("scenario").get<std::string>() + ": " + joined(j.truth, "nothing")
                                                                   : joined(j.truth, "nothing");
    if (!rows.count({group, there})) order.push_back({group, there});
    add(rows[{group, there}], j);
    add(groups[group], j);
    all.emplace_back(there, j);
    slowest = std::max(slowest, j.seconds);
    if (!j.exact && group != "outside") {
      std::string effects;
      for (const Json& e : cell.parameters.at("effects")) effects += (effects.empty() ? "" : " + ") + e.get<std::string>();
      missed.rows.push_back({effects.empty() ? there : effects, joined(j.named, "nothing"), j.verdict, j.gap_closed, cell.parameters.at("seed")});
    }
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return group_of(a.first) < group_of(b.first); });
  for (const auto& key : order) {
    const Counts& c = rows[key];
    table.rows.push_back({key.first, key.second, c.n, c.exact, c.in_pair, c.false_name, c.in_sigma, c.closed, c.silent, c.cannot});
  }
  Findings out;
  out.tables = {table, confusion(all), missed};
  add_limits(groups, slowest, out);
  return out;
}

}  // namespace host::experiments
