// The subcommand `segcal experiments`.
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include "commands.h"
#include "experiments/experiment.h"
#include "recording.h"

namespace host {
namespace {

using namespace experiments;

constexpr const char* experiments_footer = R"(Examples:
  segcal experiments --list
  segcal experiments basin --out basin --jobs 2
      160 starts; after an interruption it continues where it stopped
  segcal experiments accuracy --out accuracy --quick
  segcal experiments hidden --out hidden --jobs 2 --seeds 3
  segcal track euroc_mh01 --out mh01 && segcal experiments hidden_real mh01 --out hidden_real
  segcal experiments faults --out faults --jobs 2 --seeds 4
  segcal experiments sigma_ref REC1 REC2 --out sigma_ref

In DIR: cells/ (one file per cell; those with the same parameters are not run again), NAME.csv, NAME.json, report.html.
Times apart, the same seed gives the same files. Exit code 1: a limit of the study is missed.)";

struct ExperimentsArguments {
  std::string name;
  std::filesystem::path out;
  int jobs = 1;
  bool list = false, json = false;
  StudyOptions options;
};

const Experiment& experiment_named(const std::string& name) {
  std::string names;
  for (const Experiment& e : experiments::experiments()) {
    if (name == e.name) return e;
    names += (names.empty() ? "" : ", ") + std::string(e.name);
  }
  throw InputError("experiments: expected one of " + names + ", found '" + name + "'");
}

int list() {
  for (const Experiment& e : experiments::experiments()) {
    const std::size_t full = e.cells({}).size();
    StudyOptions quick;
    quick.quick = true;
    std::printf("%-14s %s; %zu cells, %zu with --quick\n", e.name, e.description, full, e.cells(quick).size());
  }
  return 0;
}

int run(const ExperimentsArguments& a) {
  if (a.list) return list();
  if (a.name.empty()) throw InputError("experiments: expected a name or --list (see segcal experiments --help)");
  if (a.out.empty()) throw InputError("experiments: expected --out DIR");
  const Experiment& experiment = experiment_named(a.name);
  const bool reads = a.name == "sigma_ref" || a.name == "hidden_real";
  if (!a.options.recordings.empty() && !reads)
    throw InputError("experiments " + a.name + ": expected no recordings, they are simulated");
  const bool counts = a.name == "faults" || a.name == "hidden";
  if (a.options.seeds > 0 && !counts)
    throw InputError("experiments " + a.name + ": expected no --seeds, it is for faults and hidden");
  const Findings findings = experiment.gather(run_cells(experiment, experiment.cells(a.options), a.out, a.jobs));
  write_findings(experiment, findings, a.options, a.out);
  int missed = 0;
  for (const Limit& l : findings.limits) {
    std::printf("%s: %.3g, %s %.3g: %s\n", l.what.c_str(), l.value, l.at_least ? "at least" : "at most", l.limit,
                l.met() ? "met" : "MISSED");
    missed += l.met() ? 0 : 1;
  }
  std::printf("%s: %zu of %zu limits met; %s\n", a.name.c_str(),
              findings.limits.size() - static_cast<std::size_t>(missed), findings.limits.size(),
              (a.out / "report.html").string().c_str());
  return missed > 0 ? 1 : 0;
}

}  // namespace

void add_experiments_command(CLI::App& app, int& exit_code) {
  const auto a = std::make_shared<ExperimentsArguments>();
  CLI::App* sub =
      app.add_subcommand("experiments", "reproducible studies on simulated devices: tables, pictures, limits");
  sub->add_option("NAME", a->name, "the study; --list explains them");
  sub->add_option("REC", a->options.recordings,
                  "recordings, for sigma_ref (default: simulated ones) and hidden_real (tracked)");
  sub->add_option("--out", a->out, "folder for cells/, NAME.csv, NAME.json and report.html");
  sub->add_option("--jobs", a->jobs, "cells at a time, each a process of its own")
      ->capture_default_str()
      ->check(CLI::Range(1, 256));
  sub->add_option("--seed", a->options.seed, "of all devices, motions and noise")->capture_default_str();
  sub->add_option("--calib", a->options.calibration, "starting calibration of REC, for sigma_ref");
  sub->add_option("--seeds", a->options.seeds,
                  "recordings of each kind, for faults (default: 20, 2 with --quick) and hidden (10, 1)")
      ->check(CLI::Range(1, 1000));
  sub->add_flag("--quick", a->options.quick, "fewer and shorter sessions: minutes instead of an hour");
  sub->add_flag("--list", a->list, "list the studies, one line each");
  sub->footer(experiments_footer);
  sub->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace host
