#pragma once

/// What a verdict holds figures against. Beyond the first limit of a pair a result needs a remark;
/// beyond the second nobody could defend it. "Hicks" is Hicks, Uchida, Seth, Rajagopal & Delp 2015,
/// J Biomech Eng 137:020905. The trials measured are those of tests/bench/verdicts.md: what is
/// published there must never be called not usable.
namespace sinew::limits {

constexpr const char* kHicks = "Hicks et al. 2015";
constexpr const char* kOwn = "Sinew";
constexpr const char* kMcGinley = "McGinley et al. 2009";

// Markers. Published OpenSim trials have an RMS of up to 38 mm (a planar model 30 mm), generic
// models on another person 68 mm and more, a wrong unit 600 mm.
constexpr double kMarkerRms = 0.020;  // Hicks [m]
constexpr double kWorstMarkerRms = 2.5 * kMarkerRms;
constexpr double kMarkerMax = 0.040;  // Hicks [m]
// RMS of one marker over a whole trial that is no skin's: thighs' skin moves by 30 mm over the bone
// (Leardini et al. 2005, Gait Posture 21:212-225); the published trials reach 81 mm, at shoulders
// that their models lack [m].
constexpr double kLostMarker = 0.100;
// By how much a marker is farther off in a movement than in the static trial: half of what Hicks
// allow in all [m].
constexpr double kMoreThanStatic = 0.010;
// One side's markers against the other's: RMS of the worse one above Hicks' limit and so many times
// the better one's. The published trials stay below 2.
constexpr double kSideRatio = 2.5;
// A joint that moves this much less than the other side's [rad] and by this ratio: 40 degrees is
// two thirds of a knee's range in walking (Perry & Burnfield 2010).
constexpr double kSideRange = 0.7;
constexpr double kSideRangeRatio = 3.0;

// RMS by which a low-pass changes an angle: errors of gait angles that are acceptable, and that
// mislead (McGinley, Baker, Wolfe & Morris 2009, Gait Posture 29:360-369) [rad].
constexpr double kFiltered = 0.035, kWorstFiltered = 0.087;
// The same of a marker: what turns a segment of 0.3 m, a foot's or a half shank's, as far [m].
constexpr double kFilteredMarker = 0.3 * kFiltered, kWorstFilteredMarker = 0.3 * kWorstFiltered;

// Shares of the frames.
constexpr double kOnBound = 0.1, kWorstOnBound = 0.5;
constexpr double kUnmeasured = 0.0, kWorstUnmeasured = 0.5;
constexpr double kFilled = 0.1;  // of the tracked samples
constexpr double kFallen = 0.5;  // feet more than 60 degrees from below the pelvis

// What is left at the root, over the largest ground force, and over height times that.
constexpr double kResidualForce = 0.05, kResidualMoment = 0.01;  // Hicks
// Half of the ground's force unexplained. Published trials: up to 16 % where all loads are known.
constexpr double kWorstResidualForce = 10.0 * kResidualForce;
// The whole ground force a fifth of the body's height away from where it acts, more than a foot is
// long (0.152 of the height, Drillis & Contini 1966). Published trials: up to 6 %.
constexpr double kWorstResidualMoment = 20.0 * kResidualMoment;
// What pushes sideways, over the weight: in walking 0.1 and more forwards, 0.03 sideways (Winter
// 2009); less is another's noise. Minus the cosine to what the movement needs: measured ones agree
// to 0.8 and more.
constexpr double kLeastPush = 0.02;
constexpr double kTurnedPush = 0.5;
// A load that pushes less than this part of what is needed of it pushes not at all; published ones
// push a sixth and more.
constexpr double kDeadPush = 0.05;
// What a turn by a right angle leaves of the horizontal force at the root: as much as a turned sign
// does at that cosine, sqrt((1 - 0.5) / (1 + 0.5)).
constexpr double kTurnLeaves = 0.577;
// A frame lacks loads where this much of the weight hangs on the root: in walking each leg carries
// as much for most of its stance.
constexpr double kUncarried = 0.5;
// What the loads carry on average, over the model's weight: clothes, shoes and an unsteady walk
// make 3 %; a mass in pounds makes 2.2.
constexpr double kMass = 0.03, kWorstMass = 0.3;
// The same where no strides are known and the record may begin and end in the middle of a step.
constexpr double kMassOfTable = 0.15;

// The body. Mass over squared height [kg/m²]: severe thinness in adults begins at 16, children of
// five have 13 (WHO); the third class of obesity begins at 40.
constexpr double kThin = 12.0, kWorstThin = 10.0;
constexpr double kHeavy = 45.0, kWorstHeavy = 60.0;
// No person whom markers were put on weighed as much; nobody was taller than 2.72 m [kg, m].
constexpr double kHeaviest = 300.0;
constexpr double kShort = 0.8, kWorstShort = 0.4;
constexpr double kTall = 2.2, kWorstTall = 2.8;
// Of the height: where the hip is (Drillis & Contini 1966).
constexpr double kHipHeight = 0.530;
// Left against right segments: legs differ by 5 mm on average and by more than 20 mm in one of a
// thousand (Knutson 2005, Chiropr Osteopat 13:11) [fraction, m].
constexpr double kSideLength = 0.05, kSideLengthLeast = 0.02;

// Factors of scaling, from an adult model: a child of one year has 0.43 of an adult's height, a
// grown person between 0.8 and 1.3. Published setups have up to 2.
constexpr double kSmallFactor = 0.6, kWorstSmallFactor = 0.25;
constexpr double kLargeFactor = 1.5, kWorstLargeFactor = 3.0;
constexpr double kMovedMarker = kMarkerMax;

}  // namespace sinew::limits
