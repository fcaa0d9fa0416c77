// SPDX-License-Identifier: Apache-2.0
// Tables as the makers of cyclers and loggers write them are read without a map: one cell of 4 V and 10 mOhm.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <string>

#include "io/logs/cell_log.hpp"
#include "io/logs/plain_columns.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

struct Row {
  int k = 0;
  double time_s = 0.0, current_a = 0.0, voltage_v = 4.0;  // discharge positive
};

std::string rows_of(const std::function<std::string(const Row&)>& line) {
  std::string out;
  for (int k = 0; k < 60; ++k) {
    const double current = (k / 10) % 2 == 0 ? 0.0 : k < 40 ? 10.0 : -5.0;
    out += line({k, 0.5 * k, current, 4.0 - 0.01 * current}) + "\n";
  }
  return out;
}

std::string with_comma(std::string text) {
  for (char& c : text) c = c == '.' ? ',' : c;
  return text;
}

std::string clock_of(double seconds) {
  return fmt::format("00:{:02}:{:06.3f}", static_cast<int>(seconds) / 60, std::fmod(seconds, 60.0));
}

}  // namespace

TEST_GROUP(MakerTables) {
  Scratch scratch;
  DataFolder data{VOLTLAP_DATA_FOLDER};

  CellLog log_of(const std::string& text) { return read_cell_log(scratch.write("a.csv", text), nullptr, data); }
  void is_the_cell(const std::string& text) {
    CellLog log;
    const std::string refused = complaint([&] { log = log_of(text); });
    STRCMP_EQUAL("no error", refused.c_str());
    LONGS_EQUAL(60, log.rows());
    for (std::size_t row = 0; row < log.rows(); ++row) {
      const double current = (row / 10) % 2 == 0 ? 0.0 : row < 40 ? 10.0 : -5.0;
      DOUBLES_EQUAL(current, log.current_a[row], 1e-6);
      DOUBLES_EQUAL(4.0 - 0.01 * current, log.voltage_v[row], 1e-6);
      DOUBLES_EQUAL(0.5 * static_cast<double>(row), log.time_s[row] - log.time_s[0], 1e-5);
    }
  }
  std::string refusal(const std::string& text) {
    return complaint([&] { (void)log_of(text); });
  }
};

TEST(MakerTables, ArbinCountsDischargeAloneWhereNothingIsCharged) {
  // Its counter of charge stands still; the other tells what a gap drew. The thermometer's number is behind its unit.
  const auto table = [](int unmoved) {
    std::string text =
        "Test_Time(s),Current(A),Voltage(V),Charge_Capacity(Ah),Discharge_Capacity(Ah),Temperature (C)_1\n";
    for (int k = 0; k < 60; ++k) {
      if (k >= 30 && k < 45) continue;
      const double current = k >= 10 ? 10.0 : 0.0, drawn = 10.0 * std::max(0, k - 10) * 60.0 / 3600.0;
      const double charged = unmoved != 0 ? 0.0 : k < 5 ? 0.0 : 1e-4;
      text += fmt::format("{},{:.4f},{:.4f},{:.6f},{:.6f},29.5\n", 60 * k, -current, 4.0 - 0.01 * current, charged,
                          drawn);
    }
    return text;
  };
  for (const int unmoved : {0, 1}) {
    const CellLog log = log_of(table(unmoved));
    CHECK_EQUAL(45, log.rows());
    CHECK_EQUAL(log.rows(), log.charge_ah.size());
    DOUBLES_EQUAL(10.0 * 49.0 / 60.0, log.charge_ah.back() - log.charge_ah.front(), 1e-3);
    DOUBLES_EQUAL(29.5, log.temperature_c.front(), 1e-9);
  }
}

TEST(MakerTables, Arbin) {
  is_the_cell("Data_Point,Test_Time(s),Step_Time(s),Step_Index,Current(A),Voltage(V),Charge_Capacity(Ah),dV/dt(V/s)\n" +
              rows_of([](const Row& r) {
                return fmt::format("{},{:.2f},{:.2f},1,{:.4f},{:.4f},0,0", r.k, r.time_s, std::fmod(r.time_s, 5.0),
                                   -r.current_a, r.voltage_v);
              }));
}

TEST(MakerTables, MaccorAmountsGetTheirSignFromTheState) {
  is_the_cell("Today's Date 04/11/2016  Date of Test: 03/31/2016  Procedure: a.000\n"
              "Rec#\tCyc#\tStep\tTestTime\tAmp-hr\tAmps\tVolts\tState\n" +
              rows_of([](const Row& r) {
                return fmt::format("{}\t0\t1\t  0d {}\t0.0\t{:.4f}\t{:.4f}\t{}", r.k, clock_of(r.time_s),
                                   std::abs(r.current_a), r.voltage_v,
                                   r.current_a > 0.0 ? "D" : r.current_a < 0.0 ? "C" : "R");
              }));
}

TEST(MakerTables, NewareWithTimesOfTheStepAndWithLevels) {
  is_the_cell("Record ID,Step Name,Cur(mA),Voltage(V),relative time(h:min:s.ms),Total Time(h:min:s.ms)\n" +
              rows_of([](const Row& r) {
                return fmt::format("{},CC,{:.1f},{:.4f},{},{}", r.k, -1e3 * r.current_a, r.voltage_v,
                                   clock_of(std::fmod(r.time_s, 5.0)), clock_of(r.time_s));
              }));
  is_the_cell("Cycle ID,Cap(mAh)\n,Step ID,Step Name\n,,Record ID,Voltage(V),Current(mA),Total Time(s)\n1,100\n" +
              rows_of([](const Row& r) {
                return fmt::format("{},,{},{:.4f},{:.1f},{:.2f}", r.k % 10 == 0 ? ",1,CC\n" : "", r.k, r.voltage_v,
                                   -1e3 * r.current_a, r.time_s);
              }));
}

TEST(MakerTables, BioLogicInLatinOneWithDecimalCommas) {
  is_the_cell("EC-Lab ASCII FILE\nNb header lines : 5\t\n\nElectrode : \tx 1,5\n"
              "mode\ttime/s\tcontrol/V/mA\tEcell/V\tI/mA\tTemperature/\xB0" "C\n" +
              rows_of([](const Row& r) {
                return with_comma(fmt::format("2\t{:.15E}\t0.0\t{:.7E}\t{:.7E}\t25.1", r.time_s, r.voltage_v,
                                              -1e3 * r.current_a));
              }));
}

TEST(MakerTables, DigatronWithARowOfUnits) {
  is_the_cell("Name;Test 1;;;\n\nZeitstempel;Zustand;Programmdauer;Spannung;Strom\n;;;[V];[mA]\n" +
              rows_of([](const Row& r) {
                return with_comma(fmt::format("x;DCH;{:.3f};{:.4f};{:.3f}", r.time_s, r.voltage_v, -1e3 * r.current_a));
              }));
}

TEST(MakerTables, BasytecWithHours) {
  is_the_cell("~Resultfile from Basytec Battery Test System\n~Name of Test: x\n~Time[h]\tCommand\tU[V]\tI[A]\n" +
              rows_of([](const Row& r) {
                return fmt::format("{:.10f}\tPause\t{:.4f}\t{:.4f}", r.time_s / 3600, r.voltage_v, -r.current_a);
              }));
}

TEST(MakerTables, RaceLoggers) {
  is_the_cell("\"Format\",\"AiM CSV File\"\n\"Sample Rate\",\"20\"\n\"Beacon Markers\",\"12.3\",\"45.6\"\n\n"
              "\"Time\",\"GPS Speed\",\"BMS Current\",\"BMS Cell Voltage\"\n\"sec\",\"km/h\",\"A\",\"V\"\n\n" +
              rows_of([](const Row& r) {
                return fmt::format("\"{:.2f}\",\"30\",\"{:.3f}\",\"{:.4f}\"", r.time_s, r.current_a, r.voltage_v);
              }));
  is_the_cell("\"Format\",\"MoTeC CSV File\",,,\"Workbook\",\"\"\n"
              "\"Sample Rate\",\"50.000\",\"Hz\",,\"Duration\",\"12\"\n\n"
              "\"Time\",\"Pack Current\",\"Cell Voltage\"\n\"s\",\"A\",\"mV\"\n\n\n" +
              rows_of([](const Row& r) {
                return fmt::format("\"{:.2f}\",\"{:.3f}\",\"{:.1f}\"", r.time_s, r.current_a, 1e3 * r.voltage_v);
              }));
}

TEST(MakerTables, TwoColumnsThatMayBeTheCurrentAreRefusedWithBoth) {
  const auto table = [](const char* header) {
    return header + std::string("\n") + rows_of([](const Row& r) {
             return fmt::format("{},{},{},{}", r.time_s, r.current_a, 2 * r.current_a, r.voltage_v);
           });
  };
  for (const char* header : {"Time,I [A],Strom [A],Voltage", "Time,Current,Current,Voltage",
                             "time_s,current_a,current_ma,voltage_v", "Time,HV Current A,LS Current B,Voltage"}) {
    const std::string message = refusal(table(header));
    STRCMP_CONTAINS("role current", message.c_str());
    STRCMP_CONTAINS("--map", message.c_str());
  }
}

TEST(MakerTables, UnitThatIsNotKnownIsNotPassedOver) {
  const auto table = [](const char* unit) {
    return fmt::format("Time [s],I [{}],U [V]\n", unit) + rows_of([](const Row& r) {
             return fmt::format("{},{},{}", r.time_s, r.current_a, r.voltage_v);
           });
  };
  STRCMP_CONTAINS("the unit \"0.1A\"", refusal(table("0.1A")).c_str());
  STRCMP_CONTAINS("the unit \"daA\"", refusal(table("daA")).c_str());
  STRCMP_EQUAL("no error", refusal(table("measured")).c_str());
}

TEST(MakerTables, UnitOfTheMapThatContradictsTheFileIsRefusedAndOneThatIsNotGivenTaken) {
  const std::string path = scratch.write("a.csv", "Time [s],I [mA],U [V]\n" + rows_of([](const Row& r) {
                                           return fmt::format("{},{},{}", r.time_s, 1e3 * r.current_a, r.voltage_v);
                                         }));
  const auto with = [&](const char* current) {
    const std::string map = scratch.write("map.toml", fmt::format("[roles]\ntime = {{column = \"Time [s]\"}}\n"
                                                                  "current = {{column = \"I [mA]\"{}}}\n"
                                                                  "voltage = {{column = \"U [V]\"}}\n",
                                                                  current));
    const RoleMap roles = load_role_map(map);
    return read_cell_log(path, &roles, data);
  };
  DOUBLES_EQUAL(10.0, with("").current_a[15], 1e-9);
  DOUBLES_EQUAL(10.0, with(", unit = \"mA\"").current_a[15], 1e-9);
  STRCMP_CONTAINS("mA in the file and A in the map", complaint([&] { (void)with(", unit = \"A\""); }).c_str());
}
