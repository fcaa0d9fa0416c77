// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/written_identification.hpp"

#include <fmt/format.h>

#include <utility>

#include "core/errors.hpp"
#include "learn/identify/result/cell_file.hpp"
#include "learn/identify/result/cell_parameters.hpp"
#include "learn/validate/written_cell.hpp"

namespace voltlap::plant {
namespace {

double rms_v(const WrittenIdentification& written) {
  return written.identified.reference_point().result.rms_v;
}

}  // namespace

CellParameters IdentificationWriter::shipped(const std::string& cell) const {
  return load_cell(data, cell, "identify");
}

CellThermal IdentificationWriter::thermal(double capacity_ah) const {
  CellParameters cell;
  cell_body(told, {.ah = capacity_ah}, [this](const std::string& name) { return shipped(name); }).write_into(cell);
  return thermal_of(cell);
}

WrittenIdentification IdentificationWriter::with(const IdentifyOptions& options) const {
  WrittenIdentification out;
  out.each = identify(options);
  if (out.each.size() > 1) out.mean = mean_cell(out.each, names);
  out.identified = out.mean ? out.mean->identified : out.each.front();
  IdentifyResult& reference = out.identified.reference_point().result;
  reference.capacity.ah = reference.model.capacity_ah;
  out.body = cell_body(told, reference.capacity, [this](const std::string& name) { return shipped(name); });
  out.cell = cell_parameters(out.identified, out.body, cell_name, reference.notes);
  require_possible_size(out.cell, out.body);
  out.toml = cell_toml(out.cell, out.body, out.identified) + (out.mean ? spread_comment(*out.mean) : "");
  const CellParameters file = read_back(out.toml, data);
  require_possible_cell(file, out.identified, cells_in_series);
  take_errors_of_file(file, out.each, out.identified);
  return out;
}

WrittenIdentification IdentificationWriter::that_holds_most(const IdentifyOptions& options) const {
  WrittenIdentification best = with(options);
  if (best.mean) return best;  // it is none of its cells
  const double lost_v = lost_by_file(best.identified), before_v = rms_v(best);
  const auto attempt = [&](const char* what, const IdentifyOptions& simpler) {
    if (options.progress) options.progress(fmt::format("the file would miss what was fitted: {}", what));
    try {
      WrittenIdentification next = with(simpler);
      if (rms_v(next) >= rms_v(best)) return;
      best = std::move(next);
    } catch (const InputError&) {
      return;  // what is there may do
    }
    best.identified.reference_point().result.notes.push_back(fmt::format(
        "Written as {}: as what fits best it would miss a recording by {:.1f} mV and all by {:.1f} mV, because it "
        "warms otherwise than it was fitted; this misses all by {:.1f} mV. A thermometer{} would tell.",
        what, 1e3 * lost_v, 1e3 * before_v, 1e3 * rms_v(best),
        told.mass_kg ? "" : ", or the cell's body (--mass, --size),"));
  };
  if (lost_v > 0.0 && !options.method && options.block_s == 0.0) {
    IdentifyOptions simpler = options;
    simpler.branches = 1;
    if (options.branches == 0) attempt("a circuit with one RC branch", simpler);
    simpler.branches = options.branches;
    simpler.constant = true;
    if (!options.constant) attempt("a plain circuit", simpler);
  }
  require_possible_soc(best.identified);
  require_file_follows(best.identified);
  return best;
}

}  // namespace voltlap::plant
