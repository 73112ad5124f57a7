#include "tools/accuracy_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "tools/quantile.h"

namespace tactile_clay::tools {

std::string nameOf(clay::Method method) {
  return method == clay::Method::paper ? "paper" : "minimise";
}

void printHead(const Played& played) {
  std::printf("**Scene `%s`, ", played.scene.c_str());
  if (!played.material.empty()) std::printf("material `%s`, ", played.material.c_str());
  std::printf("hands `%s`%s, %.1f s, %zu particles of %.3g mm**\n\n",
              std::filesystem::path(played.hands).filename().c_str(), played.model == "soft" ? ", soft" : "",
              played.duration, played.particles, 1e3 * played.spacing);
  std::printf(
      "| solver | substeps × iterations | ms a frame | p99 | displacement | height, mm | error | force | "
      "density | volume |%s%s\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |%s%s\n",
      played.tells_skin ? " skin, mm |" : "", played.tells_rendering ? " rendering | pressure | ms |" : "",
      played.tells_skin ? " --- |" : "", played.tells_rendering ? " --- | --- | --- |" : "");
}

void printRow(const Played& played, const Row& row) {
  const Outcome& o = row.outcome;
  const Errors& e = row.errors;
  const std::string solver = (row.role == "setting" ? "" : row.role + ", ") + nameOf(row.budget.method);
  std::printf("| %s | %d × %d | %.1f | %.1f |", solver.c_str(), row.budget.substeps, row.budget.iterations,
              quantile(o.ms, 0.5), quantile(o.ms, 0.99));
  std::printf(" %.2f | %.1f | %+.1f %% |", e.displacement, 1e3 * o.height, 1e2 * e.height);
  std::printf(" %.1f %% | %.2f %% | %+.1f %% |", 1e2 * e.force, 1e2 * o.density, 1e2 * o.volume_change);
  if (played.tells_skin) std::printf(" %.3g |", 1e3 * row.skin);
  if (played.tells_rendering && row.rendering == "none") std::printf(" none | | |");
  if (played.tells_rendering && row.rendering != "none")
    std::printf(" %s | %.1f %% | %.1f |", row.rendering.c_str(), 1e2 * row.rendered.error, row.rendered.ms);
  std::printf("\n");
  std::fflush(stdout);
}

void writeCsvHead(std::ostream& csv) {
  csv << "scene,hands,spacing_m,particles,role,solver,substeps,iterations,ms_frame_median,ms_frame_p99,"
         "ms_step_median,ms_step_p99,displacement_rms_spacings,height_m,height_error,force_error,"
         "mean_force_N,mean_force_error,density_error_mean,density_error_max,volume_change,"
         "material,hand,skin_m,rendering,pressure_error,ms_rendering\n";
}

void writeCsvRow(std::ostream& csv, const Played& played, const Row& row) {
  const clay::Budget& b = row.budget;
  const Outcome& o = row.outcome;
  const Errors& e = row.errors;
  const double median = quantile(o.ms, 0.5), p99 = quantile(o.ms, 0.99);  // ms per frame
  csv << played.scene << ',' << played.hands << ',' << played.spacing << ',' << played.particles << ','
      << row.role << ',' << nameOf(b.method) << ',' << b.substeps << ',' << b.iterations << ',' << median
      << ',' << p99 << ',' << median / b.substeps << ',' << p99 / b.substeps << ',' << e.displacement << ','
      << o.height << ',' << e.height << ',' << e.force << ',' << o.mean_force << ',' << e.mean_force << ','
      << o.density << ',' << o.densest << ',' << o.volume_change << ',' << played.material << ','
      << played.model << ',' << row.skin << ',' << row.rendering << ',' << row.rendered.error << ','
      << row.rendered.ms << std::endl;
}

std::string convergence(const Doubt& doubt, const std::vector<Errors>& errors) {
  std::ostringstream text;
  text.precision(3);
  const auto tell = [&](const char* what, double Errors::*error, double unit) {
    double smallest = INFINITY;
    for (const Errors& e : errors) smallest = std::min(smallest, std::abs(e.*error));
    const double changed = std::abs(doubt.step.*error), aside = std::abs(doubt.aside.*error);
    if (!std::isfinite(changed)) return;
    text << "- " << what << ": half the step " << unit * changed << ", 1 µm aside " << unit * aside
         << ", smallest error " << unit * smallest << ": ";
    if (changed <= 0.1 * smallest)
      text << "converged";
    else if (changed <= 2.0 * aside)
      text << "converged within chance";
    else
      text << "not converged";
    text << '\n';
  };
  tell("displacement, spacings", &Errors::displacement, 1.0);
  tell("height, %", &Errors::height, 100.0);
  tell("force, %", &Errors::force, 100.0);
  return text.str();
}

}  // namespace tactile_clay::tools
