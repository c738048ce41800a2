// SPDX-License-Identifier: MIT
// Logs that are no text: MAT-files, and bags of ROS 2 in SQLite. Read as the table that a CSV is.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace nlo::trainer {

/// A column that is wanted, under the name that the file has for it.
struct WantedColumn {
  std::string heading;
  /// Between messages of another topic than the time's; else the newest one, which whoever reads holds.
  bool interpolated = false;
  double wrap = 0.0;  ///< full turn of an angle, which is interpolated the shorter way; 0: none
};

struct WantedColumns {
  std::string time;                   ///< heading of the time; empty: none
  std::vector<WantedColumn> columns;  ///< empty: all that a log may be made of, and a time if there is one
};

struct Recording {
  std::vector<std::string> headings;  ///< the time first, where it was wanted
  Eigen::MatrixXd numbers;            ///< rows x headings; NaN: nothing in this row
};

/// By its first bytes, or by its ending where it is too damaged or too new for them.
bool is_recording(const std::string& path);

/// Throws codegen::Error that names file, variable or topic, and the fix.
Recording read_recording(const std::string& path, const WantedColumns& wanted);

/// A reader of each kind, of a file that is as long as it says.
Recording read_mat_file(const std::string& path, const WantedColumns& wanted);
Recording read_rosbag(const std::string& path, const WantedColumns& wanted);

}  // namespace nlo::trainer
