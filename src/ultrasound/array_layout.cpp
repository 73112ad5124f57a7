#include "ultrasound/array_layout.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "values/pose.h"
#include "values/text.h"

namespace tactile_clay::ultrasound {
namespace {

using Cell = std::pair<int, int>;  // column, row

struct Grid {
  int columns;
  int rows;
  double pitch;               // m
  std::vector<Cell> missing;  // cells without a transducer
};

const std::map<std::string, Grid>& grids() {
  static const std::map<std::string, Grid> known = {
      {"autd3", {18, 14, 0.01016, {{1, 1}, {2, 1}, {16, 1}}}},
      {"sonic_surface", {16, 16, 0.0105, {}}},
      {"uhev1", {16, 16, 0.01047, {}}},
      {"usx", {16, 16, 0.0103, {}}},
  };
  return known;
}

std::vector<Cell> gridOrder(const Grid& grid) {
  std::vector<Cell> cells;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Cell cell(column, row);
      if (std::find(grid.missing.begin(), grid.missing.end(), cell) == grid.missing.end())
        cells.push_back(cell);
    }
  }
  return cells;
}

std::vector<Cell> readChannels(const std::string& layout, const std::string& csv,
                               const std::vector<Cell>& cells) {
  const auto fail = [&layout](int line, const std::string& what) {
    throw std::invalid_argument("channels of array layout " + layout + ", line " + std::to_string(line) +
                                ": " + what);
  };
  std::vector<Cell> order(cells.size());
  std::vector<bool> channel_seen(cells.size(), false);
  std::vector<bool> cell_seen(cells.size(), false);
  std::istringstream text(csv);
  std::string line;
  int number = 0;
  while (std::getline(text, line)) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (number == 1) {
      if (line != "channel,column,row")
        fail(number, "'" + line + "', expected the header 'channel,column,row'");
      continue;
    }
    if (line.empty()) continue;
    unsigned channel = 0;
    Cell cell;
    int end = 0;
    if (std::sscanf(line.c_str(), "%u,%d,%d%n", &channel, &cell.first, &cell.second, &end) != 3 ||
        static_cast<std::size_t>(end) != line.size()) {
      fail(number, "'" + line + "', expected channel,column,row as whole numbers");
    }
    const auto found = std::find(cells.begin(), cells.end(), cell);
    if (channel >= cells.size() || found == cells.end()) {
      fail(number, "'" + line + "', expected a channel below " + std::to_string(cells.size()) +
                       " and a column and row of the grid");
    }
    const auto index = static_cast<std::size_t>(found - cells.begin());
    if (channel_seen[channel] || cell_seen[index])
      fail(number, "'" + line + "' names a channel or cell again");
    channel_seen[channel] = true;
    cell_seen[index] = true;
    order[channel] = cell;
  }
  const auto missing = std::count(channel_seen.begin(), channel_seen.end(), false);
  if (missing > 0)
    fail(number, std::to_string(missing) + " of " + std::to_string(cells.size()) + " channels missing");
  return order;
}

}  // namespace

std::vector<std::string> arrayLayoutNames() {
  std::vector<std::string> names;
  for (const auto& entry : grids()) names.push_back(entry.first);
  return names;
}

ArrayLayout arrayLayout(const std::string& name, const std::string& channel_csv) {
  const auto entry = grids().find(name);
  if (entry == grids().end()) {
    std::string known;
    for (const std::string& n : arrayLayoutNames()) known += (known.empty() ? "" : ", ") + n;
    throw std::invalid_argument("unknown array layout '" + name + "', expected one of: " + known);
  }
  const Grid& grid = entry->second;
  std::vector<Cell> cells = gridOrder(grid);
  if (!channel_csv.empty()) cells = readChannels(name, channel_csv, cells);

  ArrayLayout layout;
  layout.name = name;
  layout.pitch = grid.pitch;
  for (const Cell& cell : cells) {
    layout.position.emplace_back((cell.first - 0.5 * (grid.columns - 1)) * grid.pitch,
                                 (cell.second - 0.5 * (grid.rows - 1)) * grid.pitch, 0.0);
  }
  layout.normal.assign(cells.size(), Eigen::Vector3d::UnitZ());
  return layout;
}

ArrayLayout placed(ArrayLayout layout, const Eigen::Isometry3d& pose) {
  for (Eigen::Vector3d& position : layout.position) position = pose * position;
  for (Eigen::Vector3d& normal : layout.normal) normal = pose.linear() * normal;
  return layout;
}

ArrayLayout joined(const std::vector<ArrayLayout>& layouts) {
  ArrayLayout all;
  for (const ArrayLayout& layout : layouts) {
    all.name += (all.name.empty() ? "" : "+") + layout.name;
    all.pitch = std::max(all.pitch, layout.pitch);
    all.position.insert(all.position.end(), layout.position.begin(), layout.position.end());
    all.normal.insert(all.normal.end(), layout.normal.begin(), layout.normal.end());
  }
  return all;
}

ArrayLayout arrayLayouts(const std::string& text) {
  std::vector<ArrayLayout> layouts;
  std::istringstream parts(text);
  std::string part;
  while (std::getline(parts, part, ';')) {
    std::istringstream words(part);
    std::string name;
    words >> name;
    std::string rest;
    std::getline(words, rest, ';');  // all of it, also if it has line breaks
    const auto numbers = values::numbersOf(rest);
    if (!numbers || (!numbers->empty() && numbers->size() != 6)) {
      throw std::invalid_argument("array layout '" + part + "', expected: name [x y z roll pitch yaw]");
    }
    const ArrayLayout layout = arrayLayout(name);
    layouts.push_back(numbers->empty() ? layout : placed(layout, values::poseOf(*numbers)));
  }
  if (layouts.empty()) return arrayLayout(text);
  return layouts.size() == 1 ? layouts.front() : joined(layouts);
}

}  // namespace tactile_clay::ultrasound
