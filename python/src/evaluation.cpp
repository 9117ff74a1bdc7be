// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>

#include <string>

#include "arrays.hpp"
#include "bindings.hpp"
#include "fransac/eval/metrics.hpp"
#include "options.hpp"

namespace fransac::python {
namespace {

struct Evaluation {
  eval::Detection dominant;
  eval::MatchedDetection matched;
  eval::BestDetection best;
  eval::InstanceMetrics planes;
};

Evaluation evaluate(nb::handle given_truth, nb::handle given_predicted, nb::handle given_share) {
  const LabelsInput truth("truth", given_truth);
  const LabelsInput predicted("predicted", given_predicted);
  double min_share = 0.0;
  read_value("min_share", given_share, min_share);
  if (!(min_share >= 0.0 && min_share <= 1.0)) raise_value_error("min_share: must be between 0 and 1");
  if (truth.shape() != predicted.shape()) raise_value_error("predicted: not of truth's shape");
  const nb::gil_scoped_release release;
  const auto measure = [](auto result) {
    if (result) return std::move(result).value();
    const nb::gil_scoped_acquire acquire;
    raise(result.error());
  };
  return {measure(eval::dominant_plane(truth.labels(), predicted.labels())),
          measure(eval::matched_plane(truth.labels(), predicted.labels())),
          measure(eval::best_overlap(truth.labels(), predicted.labels())),
          measure(eval::instance_metrics(truth.labels(), predicted.labels(), min_share))};
}

}  // namespace

void bind_evaluation(nb::module_& m) {
  using eval::Detection;
  using eval::InstanceMetrics;
  nb::class_<Detection>(m, "Detection", "Precision, recall and F1 (Zeineldin & El-Fishawy eqs. 3 to 5), from pixel counts.")
      .def_prop_ro("precision", &Detection::precision, "TP / (TP + FP); 0 when nothing was predicted.")
      .def_prop_ro("recall", &Detection::recall, "TP / (TP + FN); 0 when nothing is true.")
      .def_prop_ro("f1", &Detection::f1, "Harmonic mean; 0 when both are 0.")
      .def_ro("true_positives", &Detection::true_positives, "Pixels.")
      .def_ro("false_positives", &Detection::false_positives, "Pixels.")
      .def_ro("false_negatives", &Detection::false_negatives, "Pixels.")
      .def(
          "__repr__",
          [](const Detection& d) {
            return nb::str("<Detection precision {:.3f}, recall {:.3f}, f1 {:.3f}>")
                .attr("format")(d.precision(), d.recall(), d.f1());
          },
          nb::sig("def __repr__(self) -> str"));
  nb::class_<InstanceMetrics::AtIou>(m, "PlanesAtIou", "Planes matched at one least IoU.")
      .def_ro("threshold", &InstanceMetrics::AtIou::threshold, "The least IoU of a match.")
      .def_ro("matched", &InstanceMetrics::AtIou::matched, "Pairs.")
      .def_ro("precision", &InstanceMetrics::AtIou::precision,
              "Share of the predicted planes that are matched; what is mostly on ignored pixels and unmatched is left out.")
      .def_ro("recall", &InstanceMetrics::AtIou::recall, "Share of the true planes that are matched.")
      .def_ro("f1", &InstanceMetrics::AtIou::f1, "Harmonic mean.")
      .def_ro("mean_iou", &InstanceMetrics::AtIou::mean_iou, "Of the matched pairs; 0 without any.")
      .def(
          "__repr__",
          [](const InstanceMetrics::AtIou& a) {
            return nb::str("<PlanesAtIou {}: {} matched, precision {:.3f}, recall {:.3f}, f1 {:.3f}>")
                .attr("format")(a.threshold, a.matched, a.precision, a.recall, a.f1);
          },
          nb::sig("def __repr__(self) -> str"));
  nb::class_<InstanceMetrics>(m, "PlaneMetrics", "Matches of predicted to true planes (EVOPS 2022, Hoover et al. 1996).")
      .def_ro("true_planes", &InstanceMetrics::true_planes, "Planes of the truth that count.")
      .def_ro("predicted_planes", &InstanceMetrics::predicted_planes, "Predicted planes that count.")
      .def_ro("at50", &InstanceMetrics::at50, "IoU >= 0.5.")
      .def_ro("at75", &InstanceMetrics::at75, "IoU >= 0.75.")
      .def_ro("under_segmentation", &InstanceMetrics::under_segmentation, "Share of predicted planes over two or more true ones.")
      .def_ro("over_segmentation", &InstanceMetrics::over_segmentation, "Share of true planes under two or more predicted ones.")
      .def_ro("missed", &InstanceMetrics::missed, "Share of the true planes without a match at 0.5.")
      .def_ro("noise", &InstanceMetrics::noise, "1 - precision at 0.5; 0 when no predicted plane counts.")
      .def_ro("weighted_iou", &InstanceMetrics::weighted_iou, "Best IoU of each true plane, mean weighted by pixels.")
      .def_ro("plane_pixel_f1", &InstanceMetrics::plane_pixel_f1, "F1 of 'on some plane' over the judged pixels.");
  nb::class_<Evaluation>(m, "Evaluation", "How well labels agree with the truth.")
      .def_ro("dominant", &Evaluation::dominant, "The first predicted plane not mostly on ignored pixels, against true plane 1.")
      .def_prop_ro(
          "best", [](const Evaluation& e) { return e.best.detection; },
          "The predicted plane that overlaps true plane 1 most, against it.")
      .def_prop_ro(
          "best_label", [](const Evaluation& e) { return static_cast<int>(e.best.label); }, "Its label; 0: none overlaps.")
      .def_prop_ro(
          "matched", [](const Evaluation& e) { return e.matched.detection; },
          "The same predicted plane against the true plane that it fits best.")
      .def_prop_ro(
          "matched_label", [](const Evaluation& e) { return static_cast<int>(e.matched.label); },
          "That plane's label in the truth; 0: none.")
      .def_ro("planes", &Evaluation::planes, "All planes, matched by IoU.")
      .def(
          "__repr__", [](nb::handle self) { return nb::module_::import_("fransac._display").attr("evaluation")(self); },
          nb::sig("def __repr__(self) -> str"));
  m.def("evaluate", &evaluate, nb::arg("truth").none(), nb::arg("predicted").none(), nb::kw_only(), nb::arg("min_share") = 0.005,
        nb::sig(
            "def evaluate(truth: numpy.typing.NDArray[numpy.uint8], predicted: Segmentation | numpy.typing.NDArray[numpy.uint8], "
            "*, min_share: float = 0.005) -> Evaluation"),
        R"(Compares labels with true labels.

Parameters
----------
    truth: uint8 labels, (H, W) or (N,): 0 not judged, 1 the dominant plane, 2, ... others, 255 on no plane.
    predicted: a Segmentation, or labels of the same shape.
    min_share: planes with a smaller share of the judged pixels are left out of `planes`.

Raises
------
    TypeError: labels that are not uint8. ValueError: shapes that differ, a share outside 0 to 1.)");
}

}  // namespace fransac::python
