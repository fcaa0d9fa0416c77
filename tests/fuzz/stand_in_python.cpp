// SPDX-License-Identifier: Apache-2.0
// In the place of io/python_module.cpp: a reader of text is tried, not the Python behind it. What cantools makes of a
// DBC file is the file's own text, so that the JSON is what is drawn.
#include <stdexcept>

#include "core/errors.hpp"
#include "fuzz/target.hpp"
#include "io/python_module.hpp"

namespace voltlap::plant {

std::string run_python_module(const std::string& module, const std::vector<std::string>& arguments) {
  if (module != "voltlap_logs.dbc_json") throw std::logic_error("no stand-in for " + module);
  return content_of(arguments.at(0));
}

void run_python_module_into(const std::string&, const std::string& module, const std::vector<std::string>&) {
  throw std::logic_error("no stand-in for " + module);
}

PythonReport run_recording_module(const std::string& module, const std::vector<std::string>& arguments,
                                  const PythonStreams&) {
  throw InputError(arguments.at(0), "what " + module + " reads", "a recording in a format of text", "None");
}

std::string python_program() { return "none"; }

}  // namespace voltlap::plant
