// The studies, one file each.
#pragma once

#include "experiments/experiment.h"

namespace host::experiments {

std::vector<Cell> accuracy_cells(const StudyOptions& options);
Json accuracy_run(const Json& parameters);
Findings accuracy_gather(const std::vector<CellResult>& cells);

std::vector<Cell> repeatability_cells(const StudyOptions& options);
Json repeatability_run(const Json& parameters);
Findings repeatability_gather(const std::vector<CellResult>& cells);

std::vector<Cell> sessions_cells(const StudyOptions& options);
Json sessions_run(const Json& parameters);
Findings sessions_gather(const std::vector<CellResult>& cells);

std::vector<Cell> database_size_cells(const StudyOptions& options);
Json database_size_run(const Json& parameters);
Findings database_size_gather(const std::vector<CellResult>& cells);

std::vector<Cell> runtime_cells(const StudyOptions& options);
Json runtime_run(const Json& parameters);
Findings runtime_gather(const std::vector<CellResult>& cells);

std::vector<Cell> basin_cells(const StudyOptions& options);
Json basin_run(const Json& parameters);
Findings basin_gather(const std::vector<CellResult>& cells);

std::vector<Cell> degenerate_cells(const StudyOptions& options);
Json degenerate_run(const Json& parameters);
Findings degenerate_gather(const std::vector<CellResult>& cells);

std::vector<Cell> sigma_ref_cells(const StudyOptions& options);
Json sigma_ref_run(const Json& parameters);
Findings sigma_ref_gather(const std::vector<CellResult>& cells);

std::vector<Cell> hidden_cells(const StudyOptions& options);
Json hidden_run(const Json& parameters);
Findings hidden_gather(const std::vector<CellResult>& cells);

std::vector<Cell> hidden_real_cells(const StudyOptions& options);
Json hidden_real_run(const Json& parameters);
Findings hidden_real_gather(const std::vector<CellResult>& cells);

std::vector<Cell> measured_cells(const StudyOptions& options);
Json measured_run(const Json& parameters);
Findings measured_gather(const std::vector<CellResult>& cells);

std::vector<Cell> faults_cells(const StudyOptions& options);
Json faults_run(const Json& parameters);
Findings faults_gather(const std::vector<CellResult>& cells);

std::vector<Cell> soak_cells(const StudyOptions& options);
Json soak_run(const Json& parameters);
Findings soak_gather(const std::vector<CellResult>& cells);

}  // namespace host::experiments
