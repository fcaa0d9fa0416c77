// SPDX-License-Identifier: Apache-2.0
#include "apps/ecu_program.hpp"

#include <fmt/format.h>

#include "can_dbc/tables.hpp"

namespace voltlap::plant {
namespace {

std::string cost_text(const char* node, const StepCosts& costs) {
  if (costs.steps == 0) return "";
  return fmt::format("  instructions a tick, {}: {} mean, {} at most, at {:.2f} s after power-on\n", node,
                     costs.instructions / costs.steps, costs.worst, costs.worst_tick * can::kTickMs * 1e-3);
}

}  // namespace

EcuProgram::EcuProgram(const EcuOptions& options, const bms::Config& bms, const master::Config& master)
    : inside_(bms, master), board_(options, bms, master), bus_(board_.stream(), inside_) {
  board_.meet();
}

EcuResult EcuProgram::result() const {
  return {.where = board_.options().where, .image = board_.image(), .board = board_.stream().account()};
}

std::string EcuProgram::summary() const {
  const BoardAccount& a = board_.stream().account();
  std::string out = board_.options().where == "qemu"
                        ? fmt::format("  firmware: {} on an emulated Cortex-M4 (mps2-an386)", board_.image())
                        : fmt::format("  firmware: {} as a process of its own", board_.image());
  out += board_.own_config() ? ", with the configuration it was built with\n" : "\n";
  if (board_.other_sources()) {
    out += "  note: the image is of other firmware than this program's: other frames are no defect\n";
  }
  if (a.stack_size > 0) out += fmt::format("  stack: at most {} of {} bytes\n", a.stack_used, a.stack_size);
  return out + cost_text("BMS", a.bms) + cost_text("master", a.master);
}

}  // namespace voltlap::plant
