use touchdown_report::*;
fn main(){ let dir=std::env::args().nth(1).unwrap();
 let t:Vec<f64>=(0..20000).map(|i| i as f64*0.001).collect();
 let z:Vec<f64>=t.iter().map(|t| 0.3+(-0.3*t).exp()+0.02*(9.0*t).sin()).map(|z| if (z-0.6).abs()<0.02 {f64::NAN} else {z}).collect();
 let lo:Vec<f64>=z.iter().map(|z| z-0.1).collect(); let hi:Vec<f64>=z.iter().map(|z| z+0.1).collect();
 let f=Figure::new("demo","Approach to the deck").share_x()
  .panel(Panel::new("Time (s)","Height (m)").title("Height").series(Series::band("95 %",&t,&lo,&hi)).series(Series::line("vehicle zₚ",&t,&z)).series(Series::dashed("reference",&t,&lo)).series(Series::horizontal("deck",0.05)))
  .panel(Panel::new("Time (s)","Thrust (N)").series(Series::dotted("f_GEF",&t,&lo)).series(Series::steps("steps",&[0.,5.,10.,15.,20.],&[0.2,0.4,0.1,0.9,0.5])).series(Series::vertical("touchdown",12.3)));
 f.write(&dir).unwrap();
 let x:Vec<f64>=(0..40).map(|i| i as f64*0.1).collect();
 let g=Figure::new("demo2","Methods compared and scatter").size(900,640)
  .panel(Panel::new("Method","T_L (s)").categories(["feedback","empirical","dynamic","imbc"]).series(Series::bars("ours",&[0.,1.,2.,3.],&[3.2,2.8,f64::NAN,2.2])).series(Series::bars("published",&[0.,1.,2.,3.],&[3.0,2.9,2.1,2.3])))
  .panel(Panel::new("x (m)","Error (N)").log_y().series(Series::points("points",&x,&x)).series(Series::error_bars("err",&x,&x.iter().map(|x| x*x+0.1).collect::<Vec<_>>(),&vec![0.05;40])).series(Series::lines_points("lp",&x[..10],&x[10..20])));
 g.write(&dir).unwrap();
}
