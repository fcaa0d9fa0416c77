// SPDX-License-Identifier: Apache-2.0
// voltlap endurance: one race of a car with its firmware on the bus, in one process or on a CAN interface.
#pragma once
#include <optional>
#include <string>

#include "apps/bus_options.hpp"
#include "apps/car_options.hpp"
#include "apps/ecu_program.hpp"
#include "apps/run_recorder.hpp"
#include "io/bus/socket_bus.hpp"
#include "race/report/run_result.hpp"

namespace voltlap::plant {

/// The flags that say what is driven and what is written, and the run itself, wherever the control units are.
class EnduranceRun {
 public:
  explicit EnduranceRun(CLI::App& command);

  [[nodiscard]] EnduranceOptions options(const DataFolder& data) const;
  /// Drives, writes and prints. `socket` is the bus when that is a CAN interface, `ecu` the firmware when that is
  /// another program. Returns the exit code.
  int drive(const DataFolder& data, const EnduranceOptions& options, PlantBus& bus, const SocketBus* socket,
            EcuProgram* ecu = nullptr) const;
  CLI::Option* add_limit_costs(CLI::App& command);
  [[nodiscard]] const std::string& candump() const { return candump_; }

 private:
  [[nodiscard]] std::vector<LimitCost> costs_of(const DataFolder& data, const EnduranceOptions& chosen,
                                                const EnduranceResult& result) const;
  void open_outputs(const RunDescription& run, const EnduranceOptions& chosen, bool count_load,
                    RunRecorder& recorder) const;
  [[nodiscard]] std::string summary_of(const DataFolder& data, const EnduranceOptions& chosen,
                                       const EnduranceResult& result) const;
  [[nodiscard]] RunDescription description(const EnduranceOptions& options) const;

  CarOptions car_;
  std::string drive_, cells_ = "all", json_, csv_, candump_, report_;
  std::optional<int> laps_;
  std::uint64_t seed_ = 1;
  double rate_hz_ = 10.0;
  bool bus_load_ = false, limit_costs_ = false;
};

class EnduranceCommand {
 public:
  /// Adds the command and its flags.
  explicit EnduranceCommand(CLI::App& app);
  /// Runs it and returns the exit code. Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  EnduranceRun run_;
  BusOptions bus_;
  EcuOptions ecu_;
};

}  // namespace voltlap::plant
