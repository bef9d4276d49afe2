#include "experiments/hidden_cases.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "file_output.h"
#include "simulate/effect_names.h"
#include "simulate/random.h"

namespace host::experiments {
namespace {

constexpr double hidden_session_s = 60;
constexpr std::uint64_t seeds_apart = 10000;  // more than there are cells
/// On gentle motion an effect must be larger to show as much: statistics of equal sizes are a sixteenth (arvr) and a
/// fortieth (nav) of those of `rich`.
struct HiddenScenario {
  const char* name;
  double size;  ///< factor on all sizes
};
constexpr HiddenScenario hidden_scenarios[] = {{"rich", 1}, {"arvr", 4}, {"nav", 6}};

const HiddenSize& size_of(const std::string& name) {
  for (const auto* sizes : {&hidden_sizes(), &later_hidden_sizes()})
    for (const HiddenSize& s : *sizes)
      if (name == s.name) return s;
  throw InputError("hidden: no size for '" + name + "'");
}

/// A random direction of the given root mean square per value.
std::string direction(int values, double rms, sim::Random& random) {
  std::vector<double> v(static_cast<std::size_t>(values));
  double squares = 0;
  for (double& x : v) {
    x = values == 1 ? (random.uniform() < 0.5 ? -1 : 1) : random.normal();
    squares += x * x;
  }
  std::string text;
  for (double x : v) {
    if (!text.empty()) text += ',';
    append_number(text, x * rms * std::sqrt(values / squares));
  }
  return text;
}

/// `level` from 0, the smallest, to 1, the largest.
std::string drawn(const std::string& name, double factor, double level, sim::Random& random) {
  const HiddenSize& s = size_of(name);
  const double without = s.size * std::pow(s.largest, level), size = factor * without;
  std::string text = name + "=";
  if (name == "imu_noise" || name == "pixel_noise") {
    append_number(text, 1 + without);  // shows in the samples, whatever the motion
  } else if (name == "gyro_lag") {
    append_number(text, size);  // a lag is never negative
  } else if (name == "calibration_shift") {
    text += "cam0.r_CI,";
    append_number(text, std::round(random.uniform(20, 40)));
    text += "," + direction(3, size, random);
  } else {
    text += direction(s.values, size, random);
  }
  return text;
}

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : seed_(seed), random_(seed, sim::Stream::device) {}
  /// With white track errors and 10 images/s.
  void add(HiddenGroup group, const char* scenario, std::vector<std::string> effects) {
    add(group, scenario, "fov", "white", 10, std::move(effects));
  }
  /// The i-th of a kind: lenses in turn, every second with tracks that drift, every third with 30 images/s. Tracks that
  /// drift have hardly any white noise, so that a factor on it is no effect there.
  void add_varied(HiddenGroup group, const char* scenario, int i, std::vector<std::string> effects) {
    static const char* const lenses[] = {"fov", "radtan", "equidistant"};
    const bool drift = i % 2 && (effects.empty() || effects.front().rfind("pixel_noise", 0) != 0);
    add(group, scenario, lenses[(i / 2) % 3], drift ? "drift" : "white", i % 3 == 2 ? 30 : 10, std::move(effects));
  }
  void add(HiddenGroup group, const char* scenario, const char* distortion, const char* tracks, int images_per_s,
           std::vector<std::string> effects) {
    const std::string name = std::string(name_of(group)) + "_" + std::to_string(++count_);
    cells_.push_back({name,
                      {{"group", name_of(group)},
                       {"scenario", scenario},
                       {"distortion", distortion},
                       {"tracks", tracks},
                       {"images_per_s", images_per_s},
                       {"seconds", hidden_session_s},
                       {"seed", seed_ * seeds_apart + count_},
                       {"effects", effects}}});
  }
  sim::Random& random() { return random_; }
  std::vector<Cell> cells() const { return cells_; }

 private:
  std::uint64_t seed_, count_ = 0;
  sim::Random random_;
  std::vector<Cell> cells_;
};

void add_faults(Draw& draw, int each) {
  const std::vector<std::vector<const char*>> sizes = {{"saturation=0,0.9", "saturation=0.8,0"},
                                                       {"dropped_samples=50", "dropped_samples=200"},
                                                       {"stamp_jitter=0.0005", "stamp_jitter=0.001"}};
  for (const auto& texts : sizes)
    for (int i = 0; i < each; ++i) draw.add(HiddenGroup::fault, "rich", {texts[static_cast<std::size_t>(i) % 2]});
}

/// From the smallest to the largest size of a kind: 0 to 1.
double level(int i, int n) { return n > 1 ? static_cast<double>(i) / (n - 1) : 0.5; }

void add_outside(Draw& draw, const HiddenScenario& scenario, int n) {
  for (const HiddenOutside& o : hidden_outside()) {
    for (int i = 0; i < n; ++i) {
      std::string text = std::string(o.name) + "=";
      append_number(text, scenario.size * o.size * std::pow(4.0, level(i, n)));
      draw.add_varied(HiddenGroup::outside, scenario.name, i, {text + o.rest});
    }
  }
}

void add_pairs(Draw& draw, const HiddenScenario& scenario, int n) {
  for (int i = 0; i < n; ++i) {
    const auto& [a, b] = hidden_pairs()[static_cast<std::size_t>(i) % hidden_pairs().size()];
    const std::string first = drawn(a, scenario.size, 0.5, draw.random());
    draw.add_varied(HiddenGroup::two, scenario.name, i, {first, drawn(b, scenario.size, 0.5, draw.random())});
  }
}

/// The name of its effects: cells of one kind.
std::string kind_of(const Cell& cell) {
  std::string kind =
      cell.parameters.at("group").get<std::string>() + " " + cell.parameters.at("scenario").get<std::string>();
  for (const Json& text : cell.parameters.at("effects")) {
    const std::string effect = text;
    kind += " " + effect.substr(0, effect.find('='));
  }
  return kind;
}

/// Every kind early and late: a study that is stopped has seen something of everything.
std::vector<Cell> spread(const std::vector<Cell>& cells) {
  std::map<std::string, int> count, seen;
  for (const Cell& c : cells) ++count[kind_of(c)];
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string kind = kind_of(cells[i]);
    order.emplace_back((seen[kind]++ + 0.5) / count[kind], i);
  }
  std::sort(order.begin(), order.end());
  std::vector<Cell> out;
  for (const auto& [place, i] : order) out.push_back(cells[i]);
  return out;
}

/// "saturation=0,0.9" as shares of what the session would reach
/// without a limit: a fixed range clips nothing in a gentle session.
std::string range_from_shares(const std::string& text, const SimulationOptions& without) {
  double largest[2] = {0, 0};
  for (const ImuSample& s : simulate(without).recording.imu.samples) {
    for (double w : s.gyro) largest[0] = std::max(largest[0], std::abs(w));
    for (double f : s.accel) largest[1] = std::max(largest[1], std::abs(f));
  }
  const std::size_t comma = text.find(',');
  std::string out = "saturation=";
  append_number(out, largest[0] * std::stod(text.substr(text.find('=') + 1)));
  out += ",";
  append_number(out, largest[1] * std::stod(text.substr(comma + 1)));
  return out;
}

}  // namespace

const char* name_of(HiddenGroup group) {
  static const char* const names[] = {"none", "one", "fault", "two", "outside", "weak"};
  return names[static_cast<std::size_t>(group)];
}

HiddenGroup group_of(const std::string& name) {
  for (int g = 0; g <= static_cast<int>(HiddenGroup::weak); ++g)
    if (name == name_of(static_cast<HiddenGroup>(g))) return static_cast<HiddenGroup>(g);
  throw InputError("hidden: unknown group '" + name + "'");
}

std::vector<Cell> hidden_cases(const StudyOptions& options) {
  using G = HiddenGroup;
  Draw draw(options.seed);
  const bool quick = options.quick;
  const int each = options.seeds ? options.seeds : quick ? 1 : 10;
  for (const HiddenScenario& scenario : hidden_scenarios) {
    for (int i = 0; i < (quick ? 2 : 5 * each); ++i) draw.add_varied(G::none, scenario.name, i, {});
    for (const HiddenSize& s : hidden_sizes())
      for (int i = 0; i < each; ++i)
        draw.add_varied(G::one, scenario.name, i, {drawn(s.name, scenario.size, level(i, each), draw.random())});
    add_pairs(draw, scenario, quick ? 1 : 2 * each);
    add_outside(draw, scenario, quick ? 1 : (2 * each + 4) / 5);
  }
  add_faults(draw, each);
  for (int i = 0; i < (quick ? 2 : 4 * each); ++i) {
    std::vector<std::string> effects;
    if (i % 4 >= 2) effects.push_back(drawn("time_offset", 1, 1, draw.random()));
    draw.add(G::weak, i % 2 ? "rotation" : "still", effects);
  }
  for (const HiddenScenario& scenario : hidden_scenarios)
    for (const HiddenSize& s : later_hidden_sizes())
      for (int i = 0; i < each; ++i)
        draw.add_varied(G::one, scenario.name, i, {drawn(s.name, scenario.size, level(i, each), draw.random())});
  return spread(draw.cells());
}

SimulationResult hidden_session(const Json& parameters) {
  SimulationOptions options;
  options.scenario = parameters.at("scenario");
  options.seconds = parameters.at("seconds");
  options.seed = parameters.at("seed");
  options.distortion = distortion_from_name(parameters.at("distortion"));
  options.camera_rate_hz = parameters.at("images_per_s");
  if (parameters.at("tracks") == "drift") options.tracks = sim::drifting_tracks();
  for (const Json& text : parameters.at("effects")) {
    const bool shares = text.get<std::string>().rfind("saturation=", 0) == 0;
    options.effects.push_back(sim::parse_effect(shares ? range_from_shares(text, options) : text.get<std::string>()));
  }
  return simulate(options);
}

}  // namespace host::experiments
