#include "data/marker_sets.h"

namespace sinew {
namespace {

// Plug-in Gait and the versions 2.1 to 2.6 of the Conventional Gait Model, which add medial
// markers, metatarsal heads and clusters.
constexpr MarkerSetRow kConventional[] = {
    {"asi", "asi"}, {"psi", "psi"}, {"sho", "sho"}, {"elb", "elb"}, {"wra", "wra"},
    {"wrb", "wrb"}, {"fin", "fin"}, {"kne", "kne"}, {"knm", "knm"}, {"ank", "ank"},
    {"med", "med"}, {"hee", "hee"}, {"toe", "toe"}, {"toe", "smh"}, {"mt1", "fmh"},
    {"mt5", "vmh"}, {"hlx", "hlx"}, {"fhd", "fhd"}, {"bhd", "bhd"}};
constexpr MarkerSetRow kConventionalMidline[] = {
    {"sacr", "sacr"}, {"c7", "c7"}, {"t10", "t10"}, {"clav", "clav"}, {"strn", "strn"}};

// With medial markers of the static trial, in full and in four letters.
constexpr MarkerSetRow kHelenHayes[] = {{"asi", "asis asi"},
                                        {"sho", "shoulder sho"},
                                        {"elb", "elbow elb elbowlat"},
                                        {"elm", "elbowmed elbowmedial"},
                                        {"kne", "knee kne kneelat kneelateral lkn"},
                                        {"knm", "kneemed kneemedial mkn mkne"},
                                        {"ttc", "ttub tub"},
                                        {"gtr", "trc troch"},
                                        {"ank", "ankle ank anklelat anklelateral lma"},
                                        {"med", "anklemed anklemedial mma mank"},
                                        {"hee", "heel hee"},
                                        {"toe", "toe to"}};
constexpr MarkerSetRow kHelenHayesMidline[] = {{"sacr", "vsac vsacral sacral sacrum"}};

constexpr MarkerSetRow kCleveland[] = {{"asi", "asis"},
                                       {"psi", "psis"},
                                       {"sho", "acromium acromion"},
                                       {"elb", "elbow elbowlat"},
                                       {"elm", "elbowmed"},
                                       {"wra", "wristmed wristrad"},
                                       {"wrb", "wristlat wristuln"},
                                       {"kne", "kneelat"},
                                       {"knm", "kneemed"},
                                       {"ank", "anklelat"},
                                       {"med", "anklemed"},
                                       {"hee", "heel"},
                                       {"mt5", "toelat"},
                                       {"mt1", "toemed"},
                                       {"toe", "toemid"}};
constexpr MarkerSetRow kClevelandMidline[] = {{"sacr", "vsacral"}};

constexpr MarkerSetRow kRajagopal[] = {
    {"asi", "asi"}, {"psi", "psi"},      {"sho", "acr"},      {"elb", "lel"},
    {"elm", "mel"}, {"wra", "faradius"}, {"wrb", "faulna"},   {"kne", "lfc"},
    {"knm", "mfc"}, {"ank", "lmal"},     {"med", "mmal"},     {"hee", "cal"},
    {"toe", "toe"}, {"mt1", "mt1 met1"}, {"toe", "mt2 met2"}, {"mt5", "mt5 met5"}};
constexpr MarkerSetRow kRajagopalMidline[] = {{"c7", "c7"}, {"clav", "clav"}};

// Qualisys' CGM, CAST and full-body sets are named so: L_IAS, R_FLE, CV7.
constexpr MarkerSetRow kLandmarks[] = {{"asi", "ias asis iasis"},
                                       {"psi", "ips psis ipsis"},
                                       {"sho", "sae"},
                                       {"elb", "hle"},
                                       {"elm", "hme"},
                                       {"wra", "rsp"},
                                       {"wrb", "usp"},
                                       {"fin", "hm2"},
                                       {"mc5", "hm5"},
                                       {"gtr", "ftc"},
                                       {"kne", "fle"},
                                       {"knm", "fme"},
                                       {"hfb", "fax"},
                                       {"ttc", "ttc"},
                                       {"ank", "fal"},
                                       {"med", "tam"},
                                       {"hee", "fcc"},
                                       {"mt1", "fm1"},
                                       {"toe", "fm2"},
                                       {"mt5", "fm5"}};
constexpr MarkerSetRow kLandmarksMidline[] = {
    {"c7", "cv7"}, {"t10", "tv10"}, {"clav", "sjn"}, {"strn", "sxs"}};

// Two letters that elsewhere are ankles, elbows and clusters.
constexpr MarkerSetRow kIor[] = {{"asi", "asis"}, {"psi", "psis"}, {"gtr", "gt"}, {"kne", "le"},
                                 {"knm", "me"},   {"hfb", "hf"},   {"ttc", "tt"}, {"ank", "lm"},
                                 {"med", "mm"},   {"hee", "ca"},   {"mt1", "fm"}, {"toe", "sm"},
                                 {"mt5", "vm"}};

constexpr MarkerSetRow kSports[] = {
    {"asi", "waist*front"}, {"sho", "shouldertop"}, {"elb", "elbowout"},  {"elm", "elbowin"},
    {"fin", "hand2"},       {"kne", "kneeout"},     {"knm", "kneein"},    {"ank", "ankleout"},
    {"med", "anklein"},     {"hee", "heelback"},    {"toe", "forefoot2"}, {"mt5", "forefoot5"}};
constexpr MarkerSetRow kSportsMidline[] = {{"sacr", "waistback"}};

// ANK is the medial malleolus here: the lateral one has a name of its own.
constexpr MarkerSetRow kLateralApart[] = {
    {"kne", "lkn"}, {"knm", "mkn"}, {"ttc", "tub"}, {"ank", "lma"}, {"med", "ank"}};

// Beside bars and two markers at the knee, names of joints are centres that were computed.
constexpr MarkerSetRow kBars[] = {
    {"hjc", "hip"}, {"kjc", "knee kne"}, {"ajc", "ankle ank"}, {"ank", "mall"}};

// Key points are centres of joints, not epicondyles and malleoli, whatever they are called.
constexpr MarkerSetRow kKeyPoints[] = {{"sjc", "shoulder"}, {"ejc", "elbow"}, {"wjc", "wrist"},
                                       {"hjc", "hip"},      {"kjc", "knee"},  {"ajc", "ankle"},
                                       {"hee", "heel"},     {"hlx", "bigtoe"}};

constexpr MarkerSetRow kOpenCap[] = {
    {"asi", "asisstudy"},   {"psi", "psisstudy"}, {"sho", "shoulderstudy"}, {"elb", "lelbowstudy"},
    {"elm", "melbowstudy"}, {"kne", "kneestudy"}, {"knm", "mkneestudy"},    {"ank", "anklestudy"},
    {"med", "manklestudy"}, {"hee", "calcstudy"}, {"toe", "toestudy"},      {"mt5", "5metastudy"},
    {"hjc", "hjcstudy"}};
constexpr MarkerSetRow kOpenCapMidline[] = {{"c7", "c7study"}};

// Further abbreviations of the same words.
constexpr MarkerSetRow kUsage[] = {
    {"asi", "asip"},
    {"sho", "should ac acrom"},
    {"elb", "elblat lle lhe"},
    {"elm", "elm elbmed mle mhe melb medelb"},
    {"wra", "rad radius wristthumb"},
    {"wrb", "uln ulna wristpinky"},
    {"fin", "finger mc2"},
    {"mc5", "mc5"},
    {"gtr", "gtr trochanter greatertrochanter gt"},
    {"kne", "lek lateralknee latknee lfe lknee"},
    {"knm", "mek kmed medknee kneem mfe mknee"},
    {"hfb", "hfb fibulahead headfibula fah fhead hof"},
    {"ttc", "tuberosity tibialtuberosity"},
    {"ank", "mall latankle lankle latmall llmal lam"},
    {"med", "medankle ankm mankle mmall medmall mam"},
    {"hee", "calc calcaneus"},
    {"toe", "2mt mth2"},
    {"mt5", "5mt mth5 fifthmet"},
    {"mt1", "1mt mth1 firstmet"},
    {"hlx", "hallux bigtoe"},
    {"fhd", "headfront fronthead"},
    {"bhd", "headback backhead"},
};
constexpr MarkerSetRow kUsageMidline[] = {
    {"sacr", "sac s2"},
    {"c7", "c7th"},
    {"t10", "th10"},
    {"clav", "jugular ij clavicle suprasternale"},
    {"strn", "xiphoid px xiph xiphoidprocess"},
};

constexpr MarkerSet kSets[] = {
    {"Plug-in Gait, CGM 2",
     "Vicon, Plug-in Gait Reference Guide; Davis et al. 1991, Hum Mov Sci 10:575-587; Leboeuf et "
     "al. 2019, Gait Posture 69:235-241",
     kConventional, kConventionalMidline},
    {"Helen Hayes",
     "Kadaba, Ramakrishnan, Wootten 1990, J Orthop Res 8:383-392; Motion Analysis, OrthoTrak "
     "manual",
     kHelenHayes, kHelenHayesMidline},
    {"Cleveland Clinic", "OpenSim's example subjects: Delp et al. 2007, IEEE TBME 54:1940-1950",
     kCleveland, kClevelandMidline},
    {"Rajagopal", "Rajagopal et al. 2016, IEEE TBME 63:2068-2079", kRajagopal, kRajagopalMidline},
    {"landmarks; Qualisys' CGM, CAST and full body",
     "Van Sint Jan 2007, Color Atlas of Skeletal Landmark Definitions; Cappozzo et al. 1995, Clin "
     "Biomech 10:171-178",
     kLandmarks, kLandmarksMidline},
    {"IOR",
     "Leardini et al. 2007, Gait Posture 26:560-571; the same letters in Cappozzo et al. 1995",
     kIor,
     {},
     "hf tt lm mm ca fm sm vm",
     4},
    {"four letters, lateral malleolus apart",
     "c3d.org, sample 10: TYPE-3.c3d, by the places of its markers",
     kLateralApart,
     {},
     "lkn mkn lma tub",
     3},
    {"bars, and joints' centres",
     "c3d.org, sample 28: standing.C3D, by the places of its markers",
     kBars,
     {},
     "bar1 bar2 knee1 knee2 kne1 kne2 hip",
     4},
    {"Qualisys sports", "Qualisys, Sports Marker Set of QTM", kSports, kSportsMidline},
    {"key points of OpenPose, COCO and Halpe",
     "Cao et al. 2021, IEEE TPAMI 43:172-186 (BODY_25); Lin et al. 2014, ECCV (COCO)",
     kKeyPoints,
     {},
     "nose neck midhip bigtoe smalltoe eye ear",
     2},
    {"OpenCap", "Uhlrich et al. 2023, PLoS Comput Biol 19:e1011462", kOpenCap, kOpenCapMidline},
    {"laboratories' usage", "names seen in recordings", kUsage, kUsageMidline},
};

constexpr const char* kClusters[] = {
    "thi",     "thap",     "thad", "thl",  "thr",   "th1",           "th2",           "th3",
    "th4",     "tib",      "tiap", "tiad", "sk1",   "sk2",           "sk3",           "sk4",
    "sh1",     "sh2",      "sh3",  "sh4",  "shank", "shk",           "sha",           "leg",
    "upa",     "upperarm", "frm",  "bak",  "wand",  "thighfrontlow", "shinfronthigh", "cluster",
    "forearm", "ua1",      "ua2",  "ua3",  "tb1",   "tb2",           "tb3",           "fasuperior"};

}  // namespace

std::span<const MarkerSet> marker_sets() { return kSets; }

std::span<const char* const> cluster_names() { return kClusters; }

}  // namespace sinew
