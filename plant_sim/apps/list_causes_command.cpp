// SPDX-License-Identifier: Apache-2.0
#include "apps/list_causes_command.hpp"

#include <fmt/format.h>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {
namespace {

/// Parameters of a cause with their units and priors.
std::string parameters_text(const Cause& cause) {
  std::string out;
  for (const CauseParameter& p : cause.reported.empty() ? cause.parameters : cause.reported) {
    out += fmt::format("{}{} {:g} .. {:g}{}{}", out.empty() ? "" : ", ", p.name, p.low, p.high,
                       std::string_view(p.unit) == "1" ? "" : " ", std::string_view(p.unit) == "1" ? "" : p.unit);
  }
  return out;
}

void print_causes() {
  fmt::print("{:<30} {:<8} {:<66} {}\n", "cause", "balance", "parameters, what is believed of them", "what shows it");
  for (const Cause& cause : catalogue({})) {
    fmt::print("{:<30} {:<8} {:<66} {}\n", cause.name, name_of(cause.balance), parameters_text(cause), cause.test);
  }
}

}  // namespace

ListCausesCommand::ListCausesCommand(CLI::App& app)
    : command_(app.add_subcommand("list", "Causes that explain knows, with their parameters and what shows them")) {
  command_->add_option("what", what_, "causes")->required()->check(one_of({"causes"}));
  car_.add_vehicle(*command_);
}

int ListCausesCommand::run(const DataFolder&) {
  print_causes();
  return kExitOk;
}

}  // namespace voltlap::plant
