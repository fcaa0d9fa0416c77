// SPDX-License-Identifier: Apache-2.0
#include "io/logs/signal_words.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <span>
#include <string_view>
#include <vector>

#include "io/table/unit_name.hpp"

namespace voltlap::plant {
namespace {

struct MeaningWords {
  Meaning meaning;
  std::vector<std::string_view> words;  ///< whole words
  std::vector<std::string_view> parts;  ///< parts of words: "Batteriestrom", 充电电流
};

// German, French, Spanish, Italian, Dutch, Swedish, Russian, Chinese, Japanese beside English; "temps" is the
// French time and an English plural, so that only its unit tells.
const std::array kMeanings{
    MeaningWords{Meaning::kOther,
                 {"power",      "leistung",   "puissance", "potencia", "potenza", "p",     "energy",   "energie",
                  "resistance", "widerstand", "impedance", "kw",       "kwh",     "wh",    "w",        "ah",
                  "mah",        "capacity",   "charge",    "lap",      "step",    "cycle", "counter",  "index",
                  "status",     "state",      "flag",      "fault",    "error",   "crc",   "checksum", "id"},
                 {"leistung", "功率", "мощность", "電力", "能量", "容量", "内阻"}},
    MeaningWords{Meaning::kSoc, {"soc", "ladezustand"}, {"ladezustand", "荷电"}},
    MeaningWords{Meaning::kLateralAcceleration,
                 {"lateral", "lat", "latacc", "latg", "ay", "querbeschleunigung", "transversal"},
                 {"lateral", "querbeschleunigung", "横向加速"}},
    MeaningWords{Meaning::kAccelerator,
                 {"accelerator", "throttle", "apps", "accel", "gas", "gaspedal", "fahrpedal", "pedal"},
                 {"throttle", "accelerator", "fahrpedal", "油门", "加速踏板"}},
    MeaningWords{Meaning::kBrake, {"brake", "bremse", "frein", "freno"}, {"brake", "bremse", "制动", "刹车"}},
    MeaningWords{
        Meaning::kMotorTorque, {"torque", "drehmoment", "couple", "par"}, {"torque", "drehmoment", "扭矩"}},
    MeaningWords{Meaning::kMotorSpeed,
                 {"rpm", "revolution", "drehzahl", "revs", "régime", "regime", "giri", "varvtal", "toerental"},
                 {"revolution", "drehzahl", "转速", "оборот"}},
    MeaningWords{Meaning::kSpeed,
                 {"speed", "velocity", "geschwindigkeit", "vitesse", "velocidad", "velocita"},
                 {"speed", "geschwindigkeit", "车速", "скорость"}},
    MeaningWords{
        Meaning::kTemperature,
        {"temp", "temperature", "temperatur", "température", "temperatura", "tcell", "therm", "thermistor", "tc",
         "ntc", "pt100", "rtd", "thermocouple"},
        {"temperatur", "temp", "温度", "температура"}},
    MeaningWords{Meaning::kCurrent,
                 {"current", "curr",      "cur",      "i",      "amps",      "amp",       "amperes",
                  "courant", "corriente", "corrente", "stroom", "ström",     "ibat",      "ibatt",
                  "ipack",   "icell",     "ihv",      "idc",    "intensité", "intensite", "ток"},
                 {"current", "strom", "电流", "電流", "courant"}},
    MeaningWords{Meaning::kVoltage,
                 {"voltage",  "volt",     "volts", "v",     "u",     "tension",   "voltaje", "tensione",
                  "spanning", "spänning", "ubat",  "ubatt", "upack", "vbat",      "vbatt",   "vpack",
                  "vcell",    "ucell",    "vdc",   "udc",   "ecell", "напряжение"},
                 {"voltage", "spannung", "电压", "電圧", "電壓"}},
    MeaningWords{Meaning::kTime,
                 {"time", "t", "zeit", "temps", "tiempo", "tempo", "tijd", "tid", "seconds", "sec", "secs",
                  "timestamp", "elapsed", "время", "millis"},
                 {"zeit", "时间", "時間"}}};

struct OwnerWords {
  Owner owner;
  std::vector<std::string_view> words, parts;
};
const std::array kOwners{
    OwnerWords{
        Owner::kAmbient, {"ambient", "amb", "umgebung", "chamber", "ambiante", "ambiente"}, {"umgebung", "环境"}},
    OwnerWords{Owner::kWheel, {"wheel", "rad", "roue", "fl", "fr", "rl", "rr"}, {"wheel"}},
    OwnerWords{Owner::kCell,
               {"cell", "zelle", "zell", "cellule", "celda", "cella", "vcell", "ucell", "icell", "tcell"},
               {"cell", "zell", "单体", "电芯"}},
    OwnerWords{Owner::kBus,
               {"bus", "dclink", "link", "zk", "inverter", "inv", "umrichter"},
               {"zwischenkreis", "dclink", "母线"}},
    OwnerWords{Owner::kPack,
               {"pack",  "batt",  "battery", "bat",         "batterie", "bateria", "batteria", "akku",  "accu",
                "hv",    "ts",    "total",   "accumulator", "ams",      "bms",     "ivt",      "shunt", "ibat",
                "ibatt", "ipack", "ihv",     "ubat",        "ubatt",    "upack",   "vbat",     "vbatt", "vpack"},
               {"batter", "akku", "pack", "总", "电池"}}};

constexpr std::array kNotActual = std::to_array<std::string_view>(
    {"limit",      "limits",    "lim",      "limite",   "max",       "min",       "maximum",   "minimum",
     "high",       "low",       "highest",  "lowest",   "set",       "setpoint",  "soll",      "sp",
     "ref",        "reference", "target",   "ziel",     "cmd",       "command",   "commanded", "request",
     "requested",  "req",       "demand",   "consigne", "consigna",  "desired",   "avg",       "average",
     "mean",       "mittel",    "moyenne",  "filt",     "filtered",  "filter",    "gefiltert", "filtre",
     "lp",         "smooth",    "smoothed", "slow",     "dcl",       "ccl",       "control",   "end",
     "cut",        "cutoff",    "ripple",   "offset",   "est",       "estimated", "model",     "calc",
     "calculated", "predicted", "sim",      "peak",     "available", "allowed",   "delta",     "open",
     "ocv",        "old",       "diff",     "spread",   "imbalance"});
constexpr std::array kOthers =
    std::to_array<std::string_view>({"phase",   "phasea",   "phaseb", "phasec", "iq",  "id",        "heater", "aux",
                                     "charger", "lv",       "motor",  "mot",    "mg",  "du",        "pump",   "fan",
                                     "supply",  "inverter", "inv",    "dcdc",   "12v", "umrichter", "sensor"});
// Whose current makes the motor's torque; that of one phase, or of one axis, is another.
constexpr std::array<std::string_view, 4> kMotors{"motor", "mot", "phase", "engine"};
constexpr std::array<std::string_view, 6> kMotorsParts{"motor", "phasen", "moteur", "motore", "двигател", "电机"};
constexpr std::array<std::string_view, 13> kOfOnePhase{"phasea", "phaseb", "phasec", "a", "b", "c", "u", "v", "w",
                                                       "id",     "iq",     "d",      "q"};
// What else turns.
constexpr std::array kTurnsToo = std::to_array<std::string_view>(
    {"pump", "pumpe", "pompe", "bomba", "pompa", "fan", "lüfter", "ventilateur", "ventilador", "ventola", "coolant"});
constexpr std::array<std::string_view, 4> kNotActualParts{"sollwert", "限", "设定", "最大"};

bool has_word(const std::vector<std::string>& words, std::span<const std::string_view> wanted) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::find(wanted.begin(), wanted.end(), word) != wanted.end();
  });
}
/// A part of a longer word; a part of letters must leave a word of its own before or behind it.
bool has_part(const std::vector<std::string>& words, std::span<const std::string_view> wanted) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::any_of(wanted.begin(), wanted.end(),
                       [&](std::string_view part) { return word.find(part) != std::string::npos; });
  });
}
template <class Row>
bool says(const Row& row, const std::vector<std::string>& words) {
  return has_word(words, {row.words.begin(), row.words.size()}) ||
         has_part(words, {row.parts.begin(), row.parts.size()});
}

Meaning meaning_of(const std::vector<std::string>& words) {
  for (const MeaningWords& row : kMeanings) {
    if (has_word(words, {row.words.begin(), row.words.size()})) {
      // A single letter or a unit beside a whole word says less than it: "I_max_time", "Speed RPM".
      if (row.meaning == Meaning::kOther &&
          std::any_of(kMeanings.begin() + 1, kMeanings.end(), [&](const MeaningWords& o) {
            return has_part(words, {o.parts.begin(), o.parts.size()});
          }))
        continue;
      return row.meaning;
    }
  }
  for (const MeaningWords& row : kMeanings) {
    if (has_part(words, {row.parts.begin(), row.parts.size()})) return row.meaning;
  }
  return Meaning::kNothing;
}

bool is_digits(const std::string& word) {
  return !word.empty() &&
         std::all_of(word.begin(), word.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// The last number of a name, and the name with <n> in its place.
void take_number(std::string_view name, SpokenName& out) {
  std::size_t end = name.size();
  while (end > 0 && std::isdigit(static_cast<unsigned char>(name[end - 1])) == 0) --end;
  std::size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(name[begin - 1])) != 0) --begin;
  if (begin == end || end - begin > 6) return;
  long number = 0;
  std::from_chars(name.data() + begin, name.data() + end, number);
  out.number = number;
  out.pattern = std::string(name.substr(0, begin)) + "<n>" + std::string(name.substr(end));
}

/// Several words that are one: each of them alone means something else. "SoC" parts at its capitals.
void join_phrases(std::vector<std::string>& words) {
  using Words = std::vector<std::string>;
  static const std::vector<Words> kStateOfCharge{{"so", "c"},
                                                 {"state", "of", "charge"},
                                                 {"etat", "de", "charge"},
                                                 {"état", "de", "charge"},
                                                 {"estado", "de", "carga"},
                                                 {"stato", "di", "carica"}};
  for (const Words& phrase : kStateOfCharge) {
    const auto at = std::search(words.begin(), words.end(), phrase.begin(), phrase.end());
    if (at == words.end()) continue;
    *at = "soc";
    words.erase(at + 1, at + static_cast<std::ptrdiff_t>(phrase.size()));
  }
}

}  // namespace

std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> out;
  enum class Kind { kNone, kLower, kUpper, kDigit, kOther };
  Kind last = Kind::kNone;
  for (std::size_t k = 0; k < name.size(); ++k) {
    const auto byte = static_cast<unsigned char>(name[k]);
    const Kind kind = std::isdigit(byte) != 0                   ? Kind::kDigit
                      : std::isupper(byte) != 0                 ? Kind::kUpper
                      : std::islower(byte) != 0 || byte >= 0x80 ? Kind::kLower
                                                                : Kind::kOther;
    const bool next_is_lower = k + 1 < name.size() && std::islower(static_cast<unsigned char>(name[k + 1])) != 0;
    const bool begins =
        kind != Kind::kOther &&
        (last == Kind::kNone || last == Kind::kOther || (kind == Kind::kDigit) != (last == Kind::kDigit) ||
         (kind == Kind::kUpper && (last == Kind::kLower || (last == Kind::kUpper && next_is_lower))));
    if (begins) out.emplace_back();
    if (kind != Kind::kOther) out.back() += static_cast<char>(std::tolower(byte));
    last = kind;
  }
  join_phrases(out);
  return out;
}

bool is_of(Quantity quantity, Meaning meaning) {
  switch (meaning) {
    case Meaning::kTime:
      return quantity == Quantity::kTime;
    case Meaning::kCurrent:
      return quantity == Quantity::kCurrent;
    case Meaning::kVoltage:
      return quantity == Quantity::kVoltage;
    case Meaning::kTemperature:
      return quantity == Quantity::kTemperature;
    case Meaning::kSoc:
    case Meaning::kAccelerator:
    case Meaning::kBrake:
      return quantity == Quantity::kShare;
    case Meaning::kSpeed:
      return quantity == Quantity::kSpeed;
    case Meaning::kMotorSpeed:
      return quantity == Quantity::kRotation;
    case Meaning::kMotorTorque:
      return quantity == Quantity::kTorque;
    case Meaning::kLateralAcceleration:
      return quantity == Quantity::kAcceleration;
    default:
      return false;
  }
}

SpokenName spoken_name(std::string_view name) {
  SpokenName out;
  const ColumnName parted = column_name(name);
  // The unit at the end is no word of the name, unless it is all there is.
  const std::size_t unit_at = parted.unit.empty() ? std::string_view::npos : name.rfind(parted.unit);
  const bool has_unit = unit_at != std::string_view::npos && unit_at > 0 && unit_named(parted.unit);
  const std::string_view plain = has_unit ? name.substr(0, unit_at) : name;
  take_number(plain, out);
  if (has_unit && out.number) out.pattern += name.substr(unit_at);
  const std::vector<std::string> words = words_of(plain);
  out.meaning = meaning_of(words);
  out.is_letter = words.size() == 1 && words.front().size() == 1;
  out.is_actual = !has_word(words, kNotActual) && !has_part(words, kNotActualParts);
  out.is_others = has_word(words, kOthers);
  out.is_motors = (has_word(words, kMotors) || has_part(words, kMotorsParts)) && !has_word(words, kOfOnePhase);
  if (out.meaning == Meaning::kSpeed && out.is_others) out.meaning = Meaning::kMotorSpeed;
  const bool turns = has_unit && unit_named(parted.unit)->quantity == Quantity::kRotation;
  if (out.meaning == Meaning::kNothing && out.is_motors && turns) out.meaning = Meaning::kMotorSpeed;  // "Motor RPM"
  if (out.meaning == Meaning::kMotorSpeed && has_word(words, kTurnsToo)) out.meaning = Meaning::kOther;
  for (const OwnerWords& row : kOwners) {
    if (out.owner == Owner::kNobody && says(row, words)) out.owner = row.owner;
  }
  out.is_plain = std::all_of(words.begin(), words.end(), [](const std::string& word) {
    const std::vector<std::string> one{word};
    const auto is_owner = [&](const OwnerWords& row) { return says(row, one); };
    return is_digits(word) || meaning_of(one) != Meaning::kNothing || unit_named(word) ||
           std::any_of(kOwners.begin(), kOwners.end(), is_owner);
  });
  return out;
}

}  // namespace voltlap::plant
