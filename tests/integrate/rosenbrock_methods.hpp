// SPDX-License-Identifier: BSD-3-Clause
// Coefficients of the Rosenbrock methods with which RODAS5 is compared.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace culm::integrate {

// In the form of Rodas5 (integrate/rosenbrock.hpp). All are L-stable and stiffly accurate.

/// Hairer & Wanner (1996), Solving Ordinary Differential Equations II, section VI.4.
struct Rodas4 {
    static constexpr std::string_view name = "RODAS4";
    static constexpr std::size_t stages = 6;
    static constexpr int order = 4;
    static constexpr int embedded_order = 3;
    static constexpr double gamma = 0.25;
    static constexpr std::array<std::array<double, stages>, stages> argument{{
        {{}},
        {{1.544}},
        {{0.94667852808158259, 0.25570116989832842}},
        {{3.314825187068521, 2.8961240159722008, 0.99864191399778168}},
        {{1.2212245092266409, 6.0191344812886287, 12.53708332932087, -0.68788603610589505}},
        {{1.2212245092266409, 6.0191344812886287, 12.53708332932087, -0.68788603610589505, 1}},
    }};
    static constexpr std::array<std::array<double, stages>, stages> coupling{{
        {{}},
        {{-5.6688000000000001}},
        {{-2.4300933568338752, -0.20635991570919149}},
        {{-0.1073529058151375, -9.5945622510233548, -20.470286148096161}},
        {{7.4964433139676467, -10.246804314643519, -33.999903528199049, 11.7089089320616}},
        {{8.0832467959215215, -7.9811329880648927, -31.52159432874371, 16.31930543123136,
          -6.0588182388340543}},
    }};
};

/// Steinebach (1995), TH Darmstadt preprint 1741: keeps its order on stiff problems.
struct Rodas4p {
    static constexpr std::string_view name = "RODAS4P";
    static constexpr std::size_t stages = 6;
    static constexpr int order = 4;
    static constexpr int embedded_order = 3;
    static constexpr double gamma = 0.25;
    static constexpr std::array<std::array<double, stages>, stages> argument{{
        {{}},
        {{3}},
        {{1.8310367934867591, 0.4955183967433795}},
        {{2.3043765826926692, -0.052492752457430007, -1.176798761832782}},
        {{-7.1704549624230243, -4.7416366714817846, -16.310026313309709, -1.0620040441114009}},
        {{-7.1704549624230243, -4.7416366714817846, -16.310026313309709, -1.0620040441114009, 1}},
    }};
    static constexpr std::array<std::array<double, stages>, stages> coupling{{
        {{}},
        {{-12}},
        {{-8.791795173947035, -2.2078655869735182}},
        {{10.81793056857153, 6.780270611428266, 19.5348594464241}},
        {{34.190950067496757, 15.49671153725963, 54.747608759641302, 14.160053921485339}},
        {{34.626058309305321, 15.300849761144731, 56.999555786626672, 18.408070097930949,
          -5.7142857142857171}},
    }};
};

/// Steinebach (2023), BIT Numerical Mathematics 63:27.
struct Rodas5p {
    static constexpr std::string_view name = "RODAS5P";
    static constexpr std::size_t stages = 8;
    static constexpr int order = 5;
    static constexpr int embedded_order = 4;
    static constexpr double gamma = 0.21193756319429014;
    static constexpr std::array<std::array<double, stages>, stages> argument{{
        {{}},
        {{3}},
        {{2.8493943797479391, 0.45842242204463923}},
        {{-6.9540285098091008, 2.489845061869568, -10.358996098473584}},
        {{2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.047211872304046408}},
        {{-7.5028463993061214, 2.5618461448039191, -11.627539656261098, -0.18268767659942256,
          0.030198172008377946}},
        {{-7.5028463993061214, 2.5618461448039191, -11.627539656261098, -0.18268767659942256,
          0.030198172008377946, 1}},
        {{-7.5028463993061214, 2.5618461448039191, -11.627539656261098, -0.18268767659942256,
          0.030198172008377946, 1, 1}},
    }};
    static constexpr std::array<std::array<double, stages>, stages> coupling{{
        {{}},
        {{-14.155112264123755}},
        {{-17.97296035885952, -2.8596932954512941}},
        {{147.12150275711716, -1.41221402718213, 71.68940251302358}},
        {{165.43517024871676, -0.45928234564911258, 42.909383369586031, -5.9619867215733056}},
        {{24.854864614690072, -3.0009227002832186, 47.493111002076802, 5.5814197821558125,
          -0.66106918252494706}},
        {{30.912732140285989, -3.1208243349937974, 77.799546460708925, 34.286460282947829,
          -19.097331116725623, -28.087943162872662}},
        {{37.802771233905631, -3.2571969029072276, 112.26918849496327, 66.934723124404698,
          -40.066189370910017, -54.667802628779683, -9.4886165230962707}},
    }};
};

} // namespace culm::integrate
