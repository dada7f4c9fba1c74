use arboleda::*;
fn rng(s:&mut u64)->f32{*s^=*s<<13;*s^=*s>>7;*s^=*s<<17;((*s>>40) as f32)/16777216.0}
#[test] fn smoke(){
    let mut s=88172645463325252u64;
    for round in 0..200 {
        let n = [0,1,2,5,50,300,2000][round%7];
        let lattice = round%3==0;
        let mut q=|s:&mut u64|{let v=Vec3::new(rng(s),rng(s),rng(s))*10.0; if lattice {v.floor()} else {v}};
        let tris:Vec<Triangle>=(0..n).map(|i|{let b=q(&mut s)*(if i%2==0{1.0}else{20.0}); let k=if lattice{0.3}else{0.1};
            let mut e=||{let v=q(&mut s)*k; if lattice{v.floor()}else{v}}; let a=b+e(); let bb=b+e(); let c=b+e(); Triangle::new(a,bb,c)}).collect();
        let scene=Scene::new(&tris); let o=Options::default();
        let mut bufs=vec![];
        for k in IndexKind::ALL { let mut scratch=vec![Block::ZERO;Block::count(k.scratch_capacity(n,&o))];
            let cap=k.capacity(&scene,&o,Block::bytes(&mut scratch)).unwrap();
            let mut arena=vec![Block::ZERO;Block::count(cap.index)];
            {let a=&mut Block::bytes(&mut arena)[..cap.index-1]; match k.build(&scene,&o,a,Block::bytes(&mut scratch)){Err(BuildError::ArenaFull{needed,given})=>assert_eq!((needed,given),(cap.index,cap.index-1)),_=>panic!()};}
            {let i=k.build(&scene,&o,&mut Block::bytes(&mut arena)[..cap.index],Block::bytes(&mut scratch)).unwrap(); assert_eq!(i.as_bytes().len(),cap.index);}
            bufs.push((k,arena,cap.index)); }
        let idx:Vec<_>=bufs.iter_mut().map(|(k,a,n)|k.from_bytes(&Block::bytes(a)[..*n]).unwrap()).collect();
        for r in 0..200 {
            let o=q(&mut s)*(if r%5==0{30.0}else{1.0}); let mut d=q(&mut s)-Vec3::splat(5.0); if lattice{d=d.floor(); if d==Vec3::ZERO{d=Vec3::X}}
            if r%4==0 {d.x=0.0} if r%9==0{d.y=0.0} if d==Vec3::ZERO{d=Vec3::Z}
            let ray=Ray::new(o,d).unwrap();
            let h=idx[0].closest_hit(&ray);
            let mut b0=[Hit::NONE;5]; let mut b1=[Hit::NONE;5];
            let a0=idx[0].all_hits(&ray,&mut b0);
            for i in &idx { assert_eq!(i.closest_hit(&ray),h,"{:?}",i.kind()); assert_eq!(i.occluded(&ray),h.is_some()); assert_eq!(i.all_hits(&ray,&mut b1),a0); }
        }
    }
}
