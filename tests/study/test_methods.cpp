// SPDX-License-Identifier: BSD-3-Clause
// The published study with every integration method.
#include "run/simulate.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/point_results.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

using run::IntegrationMethod;

class PublishedStudy : public testing::Test {
  protected:
    [[nodiscard]] run::CaseSpec point(std::int64_t number,
                                      const run::Integrator& integrator) const {
        run::CaseSpec spec = case_of_point(study_.config, study_.design, number);
        spec.integrator = integrator;
        return spec;
    }

    /// b1 per cycle and b2 of points.
    struct Fits {
        std::vector<double> decay;
        std::vector<double> frequency;
    };
    [[nodiscard]] Fits fits(const std::vector<std::int64_t>& points,
                            const run::Integrator& integrator) const {
        std::vector<run::CaseSpec> specs;
        for (const std::int64_t number : points)
            specs.push_back(point(number, integrator));
        std::vector<run::CaseOutcome> outcomes = run::Simulator().simulate_together(specs);
        Fits found;
        for (std::size_t k = 0; k < specs.size(); ++k) {
            const archive::PointRecord record =
                make_record(specs[k], std::move(outcomes[k]), study_.config.reduce);
            EXPECT_TRUE(record.completed) << record.failure_reason;
            found.decay.push_back(value(record, "decay_per_cycle"));
            found.frequency.push_back(value(record, "frequency"));
        }
        return found;
    }

    static void expect_equal(const Fits& a, const Fits& b) {
        for (std::size_t k = 0; k < a.decay.size(); ++k) {
            EXPECT_NEAR(a.decay[k] / b.decay[k], 1.0, 1e-4) << "point " << k;
            EXPECT_NEAR(a.frequency[k] / b.frequency[k], 1.0, 1e-5) << "point " << k;
        }
    }

    [[nodiscard]] std::vector<std::int64_t> all_points() const {
        std::vector<std::int64_t> points;
        for (std::int64_t number = 0; number < study_.design.point_count(); ++number)
            points.push_back(number);
        return points;
    }

  private:
    [[nodiscard]] double value(const archive::PointRecord& record, const std::string& name) const {
        const auto columns = result_columns(study_.config);
        for (std::size_t k = 0; k < columns.size(); ++k)
            if (columns[k].name == name)
                return record.values[k];
        throw std::logic_error(name);
    }

    Study study_ = load_study(CULM_SOURCE_DIR "/config/schramm2019.toml");
};

run::Integrator implicit() {
    run::Integrator integrator;
    integrator.relative_tolerance = 1e-9;
    return integrator;
}

run::Integrator sundials(double tolerance) {
    run::Integrator integrator;
    integrator.method = IntegrationMethod::Sundials;
    integrator.relative_tolerance = tolerance;
    return integrator;
}

TEST_F(PublishedStudy, IsTheSameWithArkode) {
    expect_equal(fits(all_points(), sundials(1e-7)), fits(all_points(), implicit()));
}

TEST_F(PublishedStudy, IsTheSameExplicitlyAtThreePoints) {
    run::Integrator explicitly;
    explicitly.method = IntegrationMethod::Explicit;
    explicitly.timestep = 5e-9;
    const std::vector<std::int64_t> points{0, 1, 10}; // β 25 at 1 and 2 GPa, β 50 at 1 GPa
    ASSERT_EQ(point(1, explicitly).stem.bond_youngs_modulus, 2e9);
    ASSERT_EQ(point(10, explicitly).stem.bond_damping, 50.0);
    expect_equal(fits(points, explicitly), fits(points, implicit()));
}

} // namespace
} // namespace culm::study
