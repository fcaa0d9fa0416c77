// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/cell_parameters.hpp"

#include "core/parameter_file.hpp"
#include "plant_sim/core/scratch.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(CellParameters) {
  KnownCell cell;
  IdentifyOptions options;
  std::vector<std::string> notes;
  void setup() override { options.branches = 2; }
  [[nodiscard]] CellIdentification identified() const {
    return identify_cell({cell.record(cell.pulse_plan(33.0, 500, 0.0))}, {30.0}, options);
  }
};

TEST(CellParameters, OcvThatFallsIsLevelledALittleAndRefusedBeyond) {
  CellIdentification found = identified();
  const CellBody body = cell_body({}, {30.0}, [](const std::string& name) {
    return load_cell(DataFolder{VOLTLAP_DATA_FOLDER}, name, "test");
  });
  Eigen::VectorXd& em = found.points[0].result.model.em;
  const double right = em(10);
  em(10) = em(9) - 0.02;
  (void)cell_parameters(found, body, "known", notes);
  STRCMP_CONTAINS("levelled by up to", notes.back().c_str());
  em(10) = right - 5.0;
  STRCMP_CONTAINS("no rest tells it", complaint([&] { (void)cell_parameters(found, body, "known", notes); }).c_str());
}

TEST(CellParameters, OcvBeyondWhatWasPassedStaysWithinWhatWasMeasured) {
  CellIdentification found = identified();
  const CellBody body = cell_body({}, {30.0}, [](const std::string& name) {
    return load_cell(DataFolder{VOLTLAP_DATA_FOLDER}, name, "test");
  });
  IdentifyResult& result = found.points[0].result;
  for (RecordingResult& file : result.files) file.soc_low = 0.1;
  result.model.em(0) = -3.0;  // where no row was
  const CellParameters cell = cell_parameters(found, body, "known", notes);
  DOUBLES_EQUAL(cell.voltage_min_v, cell.ocv_v.front(), 1e-12);
}

TEST(CellParameters, PolynomialFollowsTheOcv) {
  const OcvPolynomial polynomial = ocv_polynomial(identified().points[0].result.model);
  LONGS_EQUAL(6, polynomial.coefficients_v.size());
  CHECK(polynomial.error_max_v < 0.06);
  double at_half = 0.0;
  for (std::size_t k = 6; k-- > 0;) at_half = at_half * 0.5 + polynomial.coefficients_v[k];
  DOUBLES_EQUAL(KnownCell::em(0.5), at_half, 0.02);
}
