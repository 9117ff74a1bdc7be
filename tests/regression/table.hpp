// SPDX-License-Identifier: Apache-2.0
/// Tables of measured numbers, versioned as CSV files.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fransac::testing {

inline constexpr double kEmpty = std::numeric_limits<double>::quiet_NaN();  ///< Where a column does not apply.

/// One number per column.
using TableRow = std::vector<double>;
/// Rows by the columns that name them, joined by commas.
using TableRows = std::map<std::string, TableRow>;

class VersionedTable {
 public:
  /// `keys` are the names of the first columns, joined by commas.
  VersionedTable(std::string file, std::string keys, std::vector<std::string_view> columns)
      : file_(std::move(file)), header_(std::move(keys)), columns_(std::move(columns)) {
    for (const std::string_view column : columns_) header_.append(",").append(column);
  }

  /// The file's rows of the dataset, the first key, must be the measured ones. With FRANSAC_UPDATE_ACCURACY in the environment
  /// they are written first; other rows are left as they stand. `share` of a number is tolerated where that is more.
  void compare(std::string_view dataset, const TableRows& measured, double tolerance, double share = 0.0) const {
    const auto of_dataset = [&](const auto& entry) { return entry.first.starts_with(std::string(dataset) + ','); };
    TableRows table = read();
    if (std::getenv("FRANSAC_UPDATE_ACCURACY") != nullptr) {
      std::erase_if(table, of_dataset);
      table.insert(measured.begin(), measured.end());
      write(table);
      table = read();
    }
    EXPECT_EQ(static_cast<std::size_t>(std::count_if(table.begin(), table.end(), of_dataset)), measured.size());
    for (const auto& [key, now] : measured) {
      const auto before = table.find(key);
      if (before == table.end()) {
        ADD_FAILURE() << key << " is not in the table";
        continue;
      }
      for (std::size_t i = 0; i < now.size(); ++i) {
        if (std::isnan(now[i]) && std::isnan(before->second[i])) continue;
        EXPECT_NEAR(now[i], before->second[i], std::max(tolerance, share * std::abs(before->second[i])))
            << key << ' ' << columns_[i];
      }
    }
  }

 private:
  [[nodiscard]] TableRows read() const {
    TableRows table;
    std::ifstream file(file_);
    std::string line;
    std::getline(file, line);
    EXPECT_TRUE(line == header_ || std::getenv("FRANSAC_UPDATE_ACCURACY") != nullptr) << line;
    while (std::getline(file, line)) {
      std::size_t end = std::string::npos;
      TableRow row(columns_.size());
      // From the last column back to the first; what is left is the key.
      for (std::size_t i = row.size(); i-- > 0;) {
        end = line.rfind(',');
        const std::string number = line.substr(end + 1);
        row[i] = number.empty() ? kEmpty : std::stod(number);
        line.resize(end);
      }
      table[line] = row;
    }
    return table;
  }

  void write(const TableRows& table) const {
    std::ofstream file(file_);
    file << header_ << '\n' << std::fixed << std::setprecision(5);
    for (const auto& [key, row] : table) {
      file << key;
      for (const double number : row) {
        file << ',';
        if (!std::isnan(number)) file << number;
      }
      file << '\n';
    }
    ASSERT_TRUE(file) << file_;
  }

  std::string file_;
  std::string header_;
  std::vector<std::string_view> columns_;
};

}  // namespace fransac::testing
