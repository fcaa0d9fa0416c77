// SPDX-License-Identifier: Apache-2.0
// `voltlap identify`: recordings of a cell to its parameter tables.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/recording_options.hpp"
#include "core/parameter_file.hpp"
#include "io/atomic_file.hpp"
#include "learn/identify/mean_cell.hpp"
#include "learn/identify/result/cell_body.hpp"
#include "learn/methods/method_comparison.hpp"

namespace voltlap::plant {

class IdentifyCommand {
 public:
  explicit IdentifyCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  int run(const DataFolder& data);

 private:
  /// A file with the flags that stood before it.
  struct Recording {
    std::string path, cell;
    double temperature_c, window_begin_s, window_end_s;
    bool temperature_given;
  };
  void add_instruments();
  [[nodiscard]] std::vector<Recording> recordings() const;
  /// The recordings of one cell.
  struct CellData {
    std::string name;
    std::vector<CellLog> logs;
    std::vector<double> temperatures_c;
    bool temperature_told = false;  ///< by a column or a flag, of at least one
  };
  [[nodiscard]] std::vector<CellData> read(const DataFolder& data) const;
  [[nodiscard]] std::vector<CellIdentification> identify_cells(const std::vector<CellData>& cells,
                                                               IdentifyOptions options) const;
  [[nodiscard]] std::vector<MethodScore> compare(const std::vector<CellData>& cells,
                                                 const std::vector<CellIdentification>& full,
                                                 IdentifyOptions options) const;
  [[nodiscard]] ToldBody told_body() const;
  /// The result files that were asked for, each there whole or not at all.
  struct Outputs {
    std::optional<AtomicFile> out, json, report;
    void commit();
  };
  void open(Outputs& files) const;
  [[nodiscard]] static std::string json_text(const CellBody& body, const std::vector<CellIdentification>& each,
                                             const std::vector<std::string>& names, const MeanCell* mean,
                                             const std::string& own);
  /// Of the cell file, else of the first recording.
  [[nodiscard]] std::string cell_name() const;
  void take_constant(const std::vector<CellData>& cells, IdentifyOptions& options) const;
  void take_method(IdentifyOptions& options) const;
  /// What was given on the command line, to repeat it.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> flags() const;
  void take_blocks(IdentifyOptions& options) const;
  void take_ocv(const DataFolder& data, IdentifyOptions& options) const;

  CLI::App* command_;
  RecordingOptions recordings_;
  std::vector<std::string> cell_;
  std::vector<double> temperatures_;
  std::vector<std::string> windows_;
  std::string method_, ocv_, blocks_, out_, json_, report_;
  int branches_ = 0;
  IdentifyOptions::Tables tables_ = IdentifyOptions::Tables::kByLaws;
  bool constant_ = false;
  std::optional<CurrentHold> hold_;
  InstrumentLimits instruments_;
  std::optional<double> capacity_ah_, mass_kg_, heat_capacity_j_per_kg_k_;
  std::string size_;
};

}  // namespace voltlap::plant
