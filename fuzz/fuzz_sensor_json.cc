// SPDX-License-Identifier: Apache-2.0
// sensor.json: any text is a valid sensor that survives a round trip, or an error with a message.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fransac/io/sensor_json.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fransac;
  const auto sensor = io::parse_sensor_json({reinterpret_cast<const char*>(data), size}, "sensor.json");
  if (!sensor) {
    if (!sensor.error().message.starts_with("sensor.json: ")) __builtin_trap();
    return 0;
  }
  if (!validate(*sensor)) __builtin_trap();
  const std::string text = io::sensor_to_json(*sensor);
  const auto again = io::parse_sensor_json(text, "again");
  if (!again || io::sensor_to_json(*again) != text) __builtin_trap();
  return 0;
}
