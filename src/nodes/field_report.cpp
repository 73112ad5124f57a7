#include "nodes/field_report.h"

#include <boost/make_shared.hpp>

#include "nodes/conversions.h"

namespace tactile_clay::nodes {

RenderingReport::Ptr fieldReport(const device::Verdict& verdict, const FocalPointArray& message,
                                 const ultrasound::Acoustics& air) {
  auto report = boost::make_shared<RenderingReport>();
  report->header = message.header;
  if (verdict.field) {
    const ultrasound::FieldSolution& field = *verdict.field;
    double both = 0.0, square = 0.0;
    for (std::size_t k = 0; k < field.wanted.size(); ++k) {
      const double clay = verdict.sound.emission.points[k].pressure;
      const double given = ultrasound::radiationPressure(air, field.on_skin[k]);
      report->wanted.push_back(static_cast<float>(ultrasound::radiationPressure(air, field.wanted[k])));
      report->granted.push_back(static_cast<float>(given));
      both += given * clay;
      square += clay * clay;
    }
    if (square > 0.0) report->gain = static_cast<float>(both / square);
    report->error = report->weighted_error = static_cast<float>(field.error);
    tellForce(message, *report);
  }
  return report;
}

}  // namespace tactile_clay::nodes
