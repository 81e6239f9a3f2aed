// SPDX-License-Identifier: BSD-3-Clause
// Columns of tables of measured stems: units, delimiters, empty cells, refusals.
#include "core/error.hpp"
#include "study/config/sections.hpp"

#include <gtest/gtest.h>

namespace culm::study {
namespace {

const Parameter& diameter = *find_parameter("bond_diameter_mm");

std::vector<double> values(std::string_view text, std::string_view column,
                           std::string_view unit = "", bool keeps_rows = false) {
    return measured_values(text, {"stems.csv", column, unit, keeps_rows}, diameter);
}

std::string column_refusal(std::string_view text, std::string_view column,
                           std::string_view unit = "", bool keeps_rows = false) {
    try {
        (void)values(text, column, unit, keeps_rows);
    } catch (const core::InputError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(MeasuredColumn, TakesItsUnitFromTheRequestItsNameOrTheParameter) {
    const std::vector<double> expected{2.57e-3, 2.61e-3};
    EXPECT_EQ(values("id,diameter_mm\na,2.57\nb,2.61\n", "diameter_mm"), expected);
    EXPECT_EQ(values("id,diameter_cm\na,0.257\nb,0.261\n", "diameter_cm"), expected);
    EXPECT_EQ(values("id,diameter\na,0.257\nb,0.261\n", "diameter", "cm"), expected);
    EXPECT_EQ(values("id,diameter\na,2.57\nb,2.61\n", "diameter"), expected);
}

TEST(MeasuredColumn, TablesOfSpreadsheetsAreRead) {
    const std::vector<double> expected{2.5e-3, 2.6e-3};
    EXPECT_EQ(values("\xEF\xBB\xBF# measured in July\r\nid;d\r\n1;2.5\r\n2;2.6\r\n", "d"),
              expected);
    EXPECT_EQ(values("id\td\n1\t2.5\n2\t2.6\n", "d"), expected);
    EXPECT_EQ(values("d\n2.5\n2.6\n", "d"), expected);
}

TEST(MeasuredColumn, EmptyCellsAreLeftOutUnlessRowsStayTogether) {
    const std::string text = "id,d\n1,2.5\n2,\n3,2.6\n";
    EXPECT_EQ(values(text, "d"), (std::vector<double>{2.5e-3, 2.6e-3}));
    EXPECT_EQ(column_refusal(text, "d", "", true),
              "stems.csv:3: d = (empty): rows = \"together\" needs every cell");
}

TEST(MeasuredColumn, ReportsMistakesWithTheirLine) {
    EXPECT_EQ(column_refusal("id,diameter_mm\n1,2.5\n", "diametr_mm"),
              "stems.csv:1: no column diametr_mm (did you mean diameter_mm?); there are id, "
              "diameter_mm");
    EXPECT_EQ(column_refusal("d\n2,5\n", "d"), "accepted") << "a second cell without a header";
    EXPECT_EQ(
        column_refusal("id;d\n1;2,5\n", "d"),
        "stems.csv:2: d = 2,5: is not a number: write digits and one decimal point, without a "
        "unit, a "
        "thousands separator, a date or a formula; leave the cell empty where nothing was seen");
    EXPECT_EQ(column_refusal("d\n2.5\n-1\n", "d"),
              "stems.csv:3: d = -1: bond_diameter_mm must be in (0, 1000] mm");
    EXPECT_EQ(column_refusal("d_gpa\n2.5\n", "d_gpa"),
              "stems.csv: column d_gpa is in GPa, but bond_diameter_mm is in mm; `unit` sets "
              "another unit");
    EXPECT_EQ(column_refusal("d\n2.5\n", "d", "ell"), "stems.csv: unknown unit ell");
    EXPECT_EQ(column_refusal("id,d\n1,\n2,\n", "d"), "stems.csv: column d holds no number");
}

} // namespace
} // namespace culm::study
